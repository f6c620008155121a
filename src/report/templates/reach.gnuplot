# Reachable porosity and k, the goal, and computed proposals: reach.dat. Given: families, family_1 and so on, k_low, k_high, porosity_low,
# porosity_high (0 and 1: any).
set xlabel 'porosity'
set ylabel 'k (m^2)'
set logscale y
set format y '10^{%L}'
set key outside right top noenhanced samplen 1.5
array colour[7] = [0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9, 0x000000]
stats 'reach.dat' using 1 name 'X' nooutput
stats 'reach.dat' using (column(2) > 1e-2 ? NaN : $2) name 'Y' nooutput
margin = 0.08*(X_max - X_min) + 1e-3
left = X_min - margin; right = X_max + margin
if (porosity_low > 0 && porosity_low < left) left = porosity_low - margin
if (porosity_high < 1 && porosity_high > right) right = porosity_high + margin
set xrange [left:right]
# A value is a thin box.
k_1 = k_low/(k_low == k_high ? 1.02 : 1); k_2 = k_high*(k_low == k_high ? 1.02 : 1)
e_1 = porosity_low <= 0 ? left : porosity_low - (porosity_low == porosity_high ? 0.002 : 0)
e_2 = porosity_high >= 1 ? right : porosity_high + (porosity_low == porosity_high ? 0.002 : 0)
set object 1 rectangle from e_1, k_1 to e_2, k_2 fillcolor rgb 0x999999 fillstyle solid 0.4 noborder
name(i) = value(sprintf('family_%d', i))
last = int(families)
plot for [i=1:last] 'reach.dat' index i-1 using 1:($3==0?$2:NaN) with lines lw 2.5 lc rgb colour[1+(i-1)%7] title name(i), \
     for [i=1:last] 'reach.dat' index i-1 using 1:($3==1?$2:NaN) with lines lw 1.5 dt 3 lc rgb colour[1+(i-1)%7] notitle, \
     'reach.dat' index last using 1:4:2:3:5:6 with xyerrorbars lw 1.5 pt 7 ps 0.7 lc rgb 0x000000 title 'computed', \
     'reach.dat' index last using 1:4:7 with labels offset 1.2,0.8 notitle
