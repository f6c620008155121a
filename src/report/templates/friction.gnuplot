# Friction factor against the modified Reynolds number: friction.csv.
set datafile separator ','
set logscale xy
set xlabel 'Re = U d_{32} / (ν (1 - ε))'
set ylabel 'friction factor'
set grid
set key top right
plot 'friction.csv' skip 1 using 1:3 with lines lw 2 lc rgb 0x2a6f9e title 'Ergun 1952', \
     '' skip 1 using 1:4 with lines lw 2 dt 2 lc rgb 0x6a9a3a title 'Carman 1937', \
     '' skip 1 using 1:5 with lines lw 2 dt 4 lc rgb 0x777777 title 'Eisfeld & Schnitzlein 2001', \
     '' skip 1 using 1:2 with points pt 7 ps 1 lc rgb 0xc07020 title 'computed'
