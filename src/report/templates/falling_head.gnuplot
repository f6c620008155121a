# Predicted water level: falling_head.csv of the falling-head stage.
set datafile separator ','
set xlabel 'time (s)'
set ylabel 'water level above the sample (m)'
set yrange [0:*]
plot 'falling_head.csv' skip 1 using 1:3 with lines lw 2 lc rgb '#909090' title 'Eq. 18', \
     'falling_head.csv' skip 1 using 1:2 with lines lw 2 lc rgb '#205080' title 'with the inertia of the water and the wire screens'
