# The paper's tortuosity against pixel size and porosity: pixels.dat, porosities.dat. Given: beds.
set multiplot layout 1,2
set grid
set key left top
set xlabel 'pixel / mm'
set ylabel 'geometric\_paper'
set yrange [1:2.6]
plot for [i=0:beds-1] 'pixels.dat' index i using 1:2 with linespoints pt 7 title columnheader(1)
set key right top
set xlabel 'porosity'
set xrange [0.3:1]
plot -2.4*x+3.27 with lines dt 2 title 'the paper, Eq. 20', 1+(1-x)*(3*pi/8-1) with lines dt 3 title 'limit for separate spheres', \
     'porosities.dat' using 1:2 with points pt 7 title 'exact', '' using 1:5 with points pt 6 title 'pixels of 0.2 mm', \
     '' using 1:6 with points pt 4 title 'pixels of 0.4 mm'
unset multiplot
