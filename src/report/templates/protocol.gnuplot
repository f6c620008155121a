# The bed after the pour, each step and each tap: protocol.csv of the pack stage.
set datafile separator ','
set datafile missing ''
set xlabel 'row of protocol.csv (0: after the pour)'
set ylabel 'porosity of the section'
set y2label 'coordination number'
set ytics nomirror
set y2tics
set key top right
plot 'protocol.csv' skip 1 using 0:6 with linespoints lw 2 pt 7 ps 0.4 lc rgb '#205080' title 'porosity', \
     'protocol.csv' skip 1 using 0:7 axes x1y2 with linespoints lw 2 pt 7 ps 0.4 lc rgb '#c07020' title 'coordination number (right)'
