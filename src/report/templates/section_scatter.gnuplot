# Scatter of k between slices of one bed against their length: section_scatter.csv.
set datafile separator ','
set logscale xy
set xlabel 'length of the slices / mm'
set ylabel 'standard deviation of k between slices / %'
set key top right
set xrange [4:80]
set yrange [1:60]
set xtics (5, 10, 20, 40, 80)
set ytics (1, 2, 5, 10, 20, 50)
plot 'section_scatter.csv' skip 1 using ($1 == 0 ? 1e3*$2 : NaN):(1e2*$4):(1e2*$5):(1e2*$6) with yerrorbars pt 7 lw 2 lc rgb '#c07020' title 'tetrapods 0.53', \
     '' skip 1 using ($1 == 1 ? 1e3*$2 : NaN):(1e2*$4):(1e2*$5):(1e2*$6) with yerrorbars pt 5 lw 2 lc rgb '#205080' title 'tetrapods 0.87', \
     40*x**-0.5 with lines dt 2 lc rgb '#555555' title 'length^{-1/2}'
