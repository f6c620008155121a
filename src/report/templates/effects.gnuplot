# Change of the water level from Eq. 18 by each effect: effects.csv. Given: columns.
set datafile separator ','
set multiplot layout 1,2
set grid
set xlabel 'time / s'
set ylabel 'water level / m'
set key right top
plot for [i=2:columns] 'effects.csv' using 1:i with lines lw 2 title columnheader(i)
set ylabel 'water level less that of Eq. 18 / mm'
plot for [i=3:columns] 'effects.csv' using 1:(1e3*(column(i)-$2)) with lines lw 2 lc i-1 title columnheader(i)
unset multiplot
