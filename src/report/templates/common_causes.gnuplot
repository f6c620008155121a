# Factors of two samples in the same draw, by the exponent of the falling inertial coefficient: common_causes.csv. Given: wanted_1 and
# wanted_2, the factors to be explained, near, the factor within which both count as given, and largest, that of the exponent.
set datafile separator ','
set grid
set logscale xy 2
set xrange [0.125:16]
set yrange [0.25:8]
set xlabel 'k true / k by the evaluation of the paper, first sample'
set ylabel 'second sample'
set cblabel 'n of the falling inertial coefficient'
set cbrange [0:largest]
set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fde725')
set object 1 rectangle from wanted_1/near, wanted_2/near to wanted_1*near, wanted_2*near front fs empty border lc rgb '#c00000' lw 2
set arrow from wanted_1, graph 0 to wanted_1, graph 1 nohead dt 2 lw 1.5
set arrow from graph 0, first wanted_2 to graph 1, first wanted_2 nohead dt 2 lw 1.5
set label sprintf('to explain: %g and %g', wanted_1, wanted_2) at graph 0.03, graph 0.95 left
plot 'common_causes.csv' every ::1 using ($1==1?$4:NaN):5:3 with points pt 7 ps 0.35 lc palette notitle
