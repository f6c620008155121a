# Convergence of the finest grid: history.csv of the lbm stage.
set datafile separator ','
set logscale y
set format y '10^{%T}'
set xlabel 'time step'
set ylabel 'relative'
set key top right
set datafile missing ''
plot 'history.csv' skip 1 using 1:($3>0?$3:NaN) with linespoints lw 2 pt 7 ps 0.3 lc rgb '#205080' title 'iteration error of k', \
     'history.csv' skip 1 using 1:($4>0?$4:NaN) with linespoints lw 2 pt 7 ps 0.3 lc rgb '#c07020' title 'difference of flow rate between layers', \
     tolerance with lines lw 1 dt 2 lc rgb '#606060' title 'tolerance of the iteration error'
