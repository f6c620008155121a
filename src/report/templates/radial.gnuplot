# Porosity and velocity against the distance from the wall: radial.csv.
set datafile separator ','
stats 'radial.csv' using 2 skip 1 name 'R' nooutput
wall = 1e3*R_max
set xlabel 'distance from the wall (mm)'
set ylabel 'porosity' textcolor rgb 0x2a6f9e
set y2label 'velocity / mean velocity of the tube' textcolor rgb 0xc07020
set yrange [0:1]
set y2range [0:*]
set ytics nomirror
set y2tics
set xrange [0:*]
set grid xtics ytics
unset key
plot 'radial.csv' skip 1 using (wall-500*($1+$2)):3 with linespoints lw 2 pt 7 ps 0.5 lc rgb 0x2a6f9e, \
     '' skip 1 using (wall-500*($1+$2)):4 axes x1y2 with linespoints lw 2 pt 5 ps 0.5 lc rgb 0xc07020
