set terminal svg size 700,600 font 'DejaVu Sans,12' background 'white'
set output 'analysis.svg'
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
curves = 1
every_nth = 4
# Measured and fitted water levels: analysis.csv. Given: curves, every_nth.
set datafile separator ','
set multiplot layout 2,1
set grid
set key off
set xlabel 'time / s'
set ylabel 'water level / m'
plot for [i=1:curves] 'analysis.csv' skip 1 every every_nth using ($1==i?$2:NaN):3 with points pt 7 ps 0.3 lc i, \
     for [i=1:curves] 'analysis.csv' skip 1 every every_nth using ($1==i?$2:NaN):4 with lines lc 'black'
set ylabel 'measured - fitted / mm'
plot for [i=1:curves] 'analysis.csv' skip 1 every every_nth using ($1==i?$2:NaN):(1e3*$5) with points pt 7 ps 0.3 lc i, 0 with lines lc 'black'
unset multiplot
