# Both packing engines. Given: pouring_us, settled_us (of the capsules), porosity, porosity_error.
set multiplot layout 2,2
set grid
set key right top
set logscale x
set xlabel 'surface tolerance of the clumps / d'
set xrange [0.003:0.2]
set logscale y
set yrange [0.1:*]
set ylabel 'us per grain and step'
plot 'seconds.dat' using 1:2 with linespoints pt 7 title 'LIGGGHTS, pouring', \
     '' using 1:3 with linespoints pt 5 title 'LIGGGHTS, settled', \
     pouring_us with lines dt 2 title 'capsules, pouring', settled_us with lines dt 3 title 'capsules, settled'
unset logscale y
set yrange [*:*]
set offsets 0, 0, 0, 0.012
set key right bottom
set ylabel 'central porosity'
plot 'porosity.dat' using 1:2:3 with yerrorbars pt 7 title 'LIGGGHTS', \
     porosity with lines dt 2 title 'capsules, +- one standard error', \
     porosity - porosity_error with lines dt 3 notitle, porosity + porosity_error with lines dt 3 notitle
unset logscale x
set offsets 0, 0, 0, 0
set xrange [0:1]
set xlabel '(r/R)^2, central part'
set ylabel 'porosity'
plot 'by_radius.dat' using 1:2:3 with yerrorlines pt 5 title 'capsules', '' using 1:4:5 with yerrorlines pt 7 title 'LIGGGHTS'
set key right top
set xrange [0:40]
set xlabel 'height / mm'
plot 'by_height.dat' using 1:2:3 with yerrorlines pt 5 title 'capsules', '' using 1:4:5 with yerrorlines pt 7 title 'LIGGGHTS'
unset multiplot
