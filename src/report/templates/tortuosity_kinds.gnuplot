# Paths and concentration behind the kinds of tortuosity: paths_geometric.dat, paths_shortest.dat, concentration.dat.
set multiplot layout 1,3
set xrange [-50:50]
set yrange [30:90]
set size ratio -1
set xlabel 'x / mm'
set ylabel 'z / mm'
unset key
unset grid
set title 'geometric\_paper'
plot 'paths_geometric.dat' with lines
set title 'shortest\_path'
plot 'paths_shortest.dat' with lines
set title 'diffusive: concentration'
unset colorbox
plot 'concentration.dat' using 1:2:3 with image pixels
unset multiplot
