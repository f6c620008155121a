# Convexity against sphericity of the paper's aggregates: sweep.csv.
set xlabel 'sphericity {/Symbol Y}'
set ylabel 'convexity {/Symbol W}'
set key right bottom
set xrange [0.4:1]
set yrange [0:1]
set datafile separator ','
plot for [kind in 'tetrahedron dolos tetrapod'] 'sweep.csv' using 2:(strcol(1) eq kind ? $5 : NaN) \
     with linespoints pt 7 ps 0.4 lw 2 title kind
