# Contributions to the uncertainty of k: budget.csv. Given: count.
set datafile separator ','
set logscale x
set xrange [0.001:100]
set yrange [-0.6:count-0.4] reverse
set xlabel 'standard uncertainty of k (%)'
set format x '%g'
set grid xtics
set border 3
set tics nomirror
unset key
set style fill solid 1.0
low = 0.001
height = 0.3
colour(part) = part == 1 ? 0x2a6f9e : part == 2 ? 0xc07020 : 0xaaaaaa
set label 1 'numerical' at graph 0.99, graph 0.94 right textcolor rgb 0x2a6f9e
set label 2 'scatter' at graph 0.99, graph 0.82 right textcolor rgb 0xc07020
set label 3 'hint' at graph 0.99, graph 0.70 right textcolor rgb 0x888888
plot 'budget.csv' skip 1 using (low):0:(low):($2 > low ? $2 : 1.1*low):($0-height):($0+height):(colour($3)):ytic(1) \
    with boxxyerror lc rgb variable
