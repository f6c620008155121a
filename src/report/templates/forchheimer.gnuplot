# Apparent permeability against the Reynolds number: forchheimer.csv.
# Bars: 1.96 times the relative error, which is a standard uncertainty. Given: k, d, k_intercept, k_in, k_in_ergun; coarser and openfoam: 1 where the table has such rows.
set datafile separator ','
set grid
set logscale x
set xlabel 'Re = U d / nu'
set ylabel 'k apparent / k'
set yrange [0:1.1]
set key left bottom
line(x, k_0, k_inertial) = 1 / (k / k_0 + k * x / d / k_inertial)
of(name, column_number) = strcol(1) eq name ? column(column_number) : NaN
plot line(x, k_intercept, k_in) with lines lc 3 title 'Forchheimer, fitted to the straight part', \
     line(x, k, k_in_ergun) with lines dt 2 lc 'gray40' title "Ergun's k_{in}", \
     'forchheimer.csv' using 2:(of('lattice', 4)):(1.96 * of('lattice', 4) * column(5)) with yerrorbars pt 7 lc 1 title 'lattice Boltzmann, 95 %', \
     for [i=1:coarser] 'forchheimer.csv' using 2:(of('coarser', 4)) with points pt 6 lc 1 title 'its next coarser grid', \
     for [i=1:openfoam] 'forchheimer.csv' using 2:(of('openfoam', 4)) with points pt 6 ps 1.3 lc 2 title 'OpenFOAM'
