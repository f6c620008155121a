# All causes at random: joint.dat (factor, share of the draws with a larger one, range factor). Given: wanted (0: nothing).
set grid
set logscale x 2
set xrange [0.25:8]
set yrange [0:1]
set xlabel 'k true / k by the evaluation of the paper'
set ylabel 'share of the draws with a larger factor'
set key top right
if (wanted > 0) {
    set arrow from wanted, graph 0 to wanted, graph 1 nohead lw 2 lc rgb '#000000' dt 2
    set label sprintf(' to explain: %g', wanted) at wanted, graph 0.6 left
}
set datafile separator ','
plot for [i=0:2] 'joint.dat' using ($3==0.5*2**i?$1:NaN):2 with lines lw 2 lc i title sprintf('ranges x %g', 0.5*2**i)
