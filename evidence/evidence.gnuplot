set terminal svg size 760,1178 font 'DejaVu Sans,11' background 'white'
set output 'evidence.svg'
set grid lc rgb '#dddddd'
set border 3
set tics nomirror
data = 'evidence.dat'
places = 64
# Ours over what others published. Given: data, places (rows of the picture).
# The data: place, ours over published, its low and high end, low and high end of the published value over itself, subject, quantity.
set xlabel 'ours over published (gray: 2 u of what was published)'
set ytics out nomirror
set grid x
set yrange [places+0.5:0]
set style fill solid 0.35 noborder
set arrow from first 1, graph 0 to first 1, graph 1 nohead lc rgb 0x555555 dt 2
array colour[7] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000]
plot data using 2:1:5:6:($1-0.32):($1+0.32):ytic(8) with boxxyerror lc rgb 0xBBBBBB notitle, \
     data using 2:1:3:4:(colour[1+(int($7)-1)%7]) with xerrorbars pt 7 ps 0.7 lw 1.5 lc rgb variable notitle
