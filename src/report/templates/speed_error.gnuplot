# Error against cost of all methods: speed_error.dat, one block per line. Given: targets (number), target_of(i) and first block first_of(i)
# as words of target_names and first_blocks.
set multiplot layout (targets + 1) / 2,2
set logscale xy
set grid
set key outside bottom center horizontal maxcols 3 samplen 1 font ',9'
set xlabel 'core seconds'
set ylabel 'error of k (%)'
set yrange [0.01:100]
set format x '%g'
# A word of the list has ~ for spaces.
with_spaces(name) = strstrt(name, '~') == 0 ? name : name[1:strstrt(name, '~')-1] . ' ' . with_spaces(name[strstrt(name, '~')+1:strlen(name)])
do for [t=1:targets] {
    set title with_spaces(word(target_names, t))
    plot 1 with lines dt 2 lc rgb 'gray' notitle, \
         for [b=int(word(first_blocks, t)):int(word(first_blocks, t + 1))-2] 'speed_error.dat' index b using 1:2 \
             with linespoints pt 7 title columnheader(1), \
         'speed_error.dat' index int(word(first_blocks, t + 1))-1 using 1:2 with lines lw 8 lc rgb '#a0c0c0c0' title columnheader(1)
}
unset multiplot
