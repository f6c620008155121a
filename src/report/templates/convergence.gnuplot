# Convergence of the finest grid: history.csv of the lbm stage.
set datafile separator ','
set logscale y
set format y '10^{%T}'
set xlabel 'time step'
set ylabel 'relative'
set key top right
plot 'history.csv' every ::2 using 1:($3>0?$3:NaN) with lines lw 2 lc rgb '#205080' title 'iteration error of k', \
     'history.csv' every ::2 using 1:($4>0?$4:NaN) with lines lw 2 lc rgb '#c07020' title 'difference of flow rate between layers'
