# Points of a study. Given: data, x_label, y_label, by_label (of the groups; may be empty), logarithmic, logarithmic_x, groups, group_1 and
# so on, curves, curve_1 and so on, marks.
# Blocks of the data: x, y, low, high of each group; then x, y of each curve; then the marks, one block each.
set xlabel x_label noenhanced
set ylabel y_label noenhanced
if (logarithmic) { set logscale y; set format y '10^{%L}' }
set key outside right top noenhanced samplen 1.5
if (strlen(by_label)) { set key title by_label noenhanced left }
array colour[7] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000]
array symbol[7] = [7, 5, 9, 13, 11, 15, 3]
name(i) = value(sprintf('group_%d', i))
stats data using 1 name 'X' nooutput
margin = X_max > X_min ? 0.05*(X_max - X_min) : 0.1*abs(X_max) + 1e-12
if (logarithmic_x) { set logscale x; set format x '10^{%L}'; set xrange [X_min/1.1:X_max*1.1] } else { set xrange [X_min-margin:X_max+margin] }
if (!logarithmic_x && X_max < 1e-3) { set format x '%.0t·10^{%T}' }
# The points last: their bars lie in front of the curves.
command = "plot"
do for [i=1:int(curves)] { command = command . sprintf(" data index %d using 1:2 with lines lw 1.5 dt %d lc rgb 0x555555 title curve_%d,", int(groups)+i-1, i+1, i) }
do for [i=1:int(marks)] { command = command . sprintf(" data index %d using 1:2 with points pt %d ps 1.4 lw 2 lc rgb 0x000000 title mark_%d,", int(groups)+int(curves)+i-1, 3+i, i) }
command = command . " for [i=1:int(groups)] data index i-1 using 1:2:3:4 with yerrorbars lw 1.5 ps 0.9 pt symbol[1+(i-1)%7] lc rgb colour[1+(i-1)%7] title name(i)"
eval command
