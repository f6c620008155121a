# Chords, pore sizes and correlation beside each other. Given: porosity.
set multiplot layout 1,3
set datafile separator ','
set datafile missing ''
set key top right
set xlabel 'length [mm]'
set ylabel 'share of longer chords'
set logscale y
set yrange [1e-3:1]
plot 'chords.csv' skip 1 using (1e3*$1):2 with lines lw 2 lc rgb '#0072B2' title 'x', \
     '' skip 1 using (1e3*$1):3 with lines lw 2 lc rgb '#E69F00' title 'y', \
     '' skip 1 using (1e3*$1):4 with lines lw 2 lc rgb '#009E73' title 'z'
unset logscale y
set yrange [0:1]
set xlabel 'diameter [mm]'
set ylabel 'pore volume in wider pores'
plot 'pore_sizes.csv' skip 1 using (1e3*$1):2 with lines lw 2 lc rgb '#0072B2' notitle
set xlabel 'distance [mm]'
set ylabel 'both ends in pores'
set yrange [0:*]
set key bottom right
plot 'correlation.csv' skip 1 using (1e3*$1):2 with lines lw 2 lc rgb '#0072B2' title 'x', \
     '' skip 1 using (1e3*$1):3 with lines lw 2 lc rgb '#E69F00' title 'y', \
     '' skip 1 using (1e3*$1):4 with lines lw 2 lc rgb '#009E73' title 'z', \
     porosity**2 with lines dt 2 lc rgb 'gray40' title 'porosity squared'
unset multiplot
