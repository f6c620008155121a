# Histogram of the grains' volumes over their median.
width = 0.05
set xlabel 'volume / median volume'
set ylabel 'grains'
set boxwidth width
set xrange [0:2]
set yrange [0:*]
set style fill solid 0.7 noborder
set arrow 1 from first 0.6, graph 0 to first 0.6, graph 1 nohead dt 2 lc rgb 'gray40'
set arrow 2 from first 1.5, graph 0 to first 1.5, graph 1 nohead dt 2 lc rgb 'gray40'
set label 1 'split' at first 0.3, graph 0.94 center textcolor rgb 'gray40'
set label 2 'merged' at first 1.75, graph 0.94 center textcolor rgb 'gray40'
plot 'volumes.dat' using (width * (floor($1 / width) + 0.5)):(1) smooth frequency with boxes lc rgb '#0072B2' notitle
