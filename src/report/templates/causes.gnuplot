# Effect of each cause on k by the paper's evaluation: causes.dat (row, factor, low, high, label). Given: rows, wanted (0: nothing).
set grid x
set logscale x 2
set xlabel 'k true / k by the evaluation of the paper'
set yrange [-0.7:rows - 0.3]
set lmargin 88
set ytics noenhanced
set key bottom right
set style fill solid 0.5
set arrow from 1, graph 0 to 1, graph 1 nohead lc 'black'
if (wanted > 0) {
    set arrow from wanted, graph 0 to wanted, graph 1 nohead lw 2 lc rgb '#c04020'
    set label sprintf(' to explain: %g', wanted) at wanted, graph 0.02 left textcolor rgb '#c04020'
}
set datafile separator ','
plot 'causes.dat' using 2:1:3:4:yticlabels(5) with xerrorbars pt 7 lc rgb '#205080' notitle
