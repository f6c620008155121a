# Tornado: k true / k by the evaluation of the paper at both ends of each range: causes.dat (row, at_low, at_high, label). Given: rows,
# wanted (0: nothing), base (without any cause).
set grid x
set logscale x 2
set xrange [0.25:8]
set xlabel 'k true / k by the evaluation of the paper'
set yrange [-0.7:rows - 0.3]
set lmargin 56
set ytics noenhanced
set key outside top center horizontal
set style fill solid 0.7 noborder
if (wanted > 0) {
    set arrow from wanted, graph 0 to wanted, graph 1 nohead lw 2 lc rgb '#000000' dt 2
    set label sprintf(' to explain: %g', wanted) at wanted, graph 0.03 left offset 1,0
}
set datafile separator ','
clip(x) = x < 0.25 ? 0.25 : (x > 8 ? 8 : x)
plot 'causes.dat' using (base):1:(base < clip($2) ? base : clip($2)):(base < clip($2) ? clip($2) : base):($1-0.35):($1+0.35) with boxxyerror lc rgb '#0072b2' title 'at the low end', \
     '' using (base):1:(base < clip($3) ? base : clip($3)):(base < clip($3) ? clip($3) : base):($1-0.2):($1+0.2):yticlabels(4) with boxxyerror lc rgb '#e69f00' title 'at the high end'
