# k against the length of the section, with constant pressure on its planes and in situ: section_length.csv.
set datafile separator ','
set grid
set logscale x 2
set xlabel 'length of the section / mm'
set ylabel 'k / 10^{-7} m^2'
set yrange [5:8.5]
set key top right
plot 'section_length.csv' using (1000*$1):(1e7*$2) every ::1 with linespoints pt 7 lc rgb '#c07020' title 'constant pressure on its planes', \
     '' using (1000*$1):(1e7*$3) every ::1 with linespoints pt 5 lc rgb '#205080' title 'in situ, with buffers'
