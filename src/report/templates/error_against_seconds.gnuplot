# Error against seconds of the lattice Boltzmann schemes: error_against_seconds.dat. Given: schemes.
set logscale xy
set xlabel 'seconds'
set ylabel 'error of k (%)'
set grid
set key outside bottom
plot for [i=0:schemes-1] 'error_against_seconds.dat' index i using 1:2 with linespoints pt 7 title columnheader(1)
