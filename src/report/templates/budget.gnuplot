# Contributions to the uncertainty of k: budget.csv. Given: count.
set datafile separator ','
set logscale x
set xrange [0.001:100]
set yrange [count-0.4:-0.6]
set xlabel 'standard uncertainty of k (%)'
set format x '%g'
set grid xtics
set border 3
set tics nomirror
unset key
set style fill solid 1.0
low = 0.001
height = 0.3
colour(part) = part == 1 ? 0x2a6f9e : part == 2 ? 0xc07020 : part == 4 ? 0xa03030 : 0xaaaaaa
plot 'budget.csv' skip 1 using (low):0:(low):($2 > low ? $2 : 1.1*low):($0-height):($0+height):(colour($3)):ytic(1) \
    with boxxyerror lc rgb variable
