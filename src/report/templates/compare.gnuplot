# Quantities of several results, relative to the first; open circles: without an interval. Given: places, label_1 and so on, count, title_1 and so on.
set xrange [-0.5:places-0.5]
set xtics () rotate by -25 noenhanced
do for [i=1:int(places)] { set xtics add (value(sprintf('label_%d', i)) i-1) }
set bmargin 10
set ylabel 'relative to the first result'
set key outside top center maxrows 4 noenhanced
plot for [i=1:int(count)] 'compare.dat' using ($1==i-1 && $6>0.5 ? $2 : NaN):3:4:5 with yerrorbars lw 2 pt 7 lc i title value(sprintf("title_%d", i)), \
     for [i=1:int(count)] '' using ($1==i-1 && $6<0.5 ? $2 : NaN):3 with points lw 2 pt 6 lc i notitle
