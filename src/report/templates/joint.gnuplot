# All causes at random: joint.dat (factor, share of the draws with a larger one, number of the set). Given: count,
# title_1 and so on, wanted (0: nothing).
set grid
set logscale x 2
set xrange [0.25:8]
set yrange [0:1]
set xlabel 'k true / k by the evaluation of the paper'
set ylabel 'share of the draws with a larger factor'
set key outside top center maxrows 2 noenhanced
if (wanted > 0) {
    set arrow from wanted, graph 0 to wanted, graph 1 nohead lw 2 lc rgb '#000000' dt 2
    set label sprintf(' to explain: %g', wanted) at wanted, graph 0.08 left offset 1,0
}
set datafile separator ','
plot for [i=1:int(count)] 'joint.dat' using ($3==i?$1:NaN):2 with lines lw 2 lc i title value(sprintf("title_%d", i))
