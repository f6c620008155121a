# Porosity and permeability along z: porosity.csv of the voxelise stage, subsections.csv from the lbm stage's result.
set datafile separator ','
set multiplot layout 2,1 margins 0.12,0.97,0.13,0.96 spacing 0,0.06
set xrange [z_low:z_high]
set offsets graph 0, graph 0, graph 0.1, graph 0.1
set key off
set format x ''
set ylabel 'porosity'
set object 1 rectangle from section_low, graph 0 to section_high, graph 1 fc rgb '#e8eef5' fs noborder behind
plot 'porosity.csv' skip 1 using (0.5*($1+$2)):3 with histeps lw 2 lc rgb '#205080'
set format x '%g'
set xlabel 'z (m)'
power = floor(log10(permeability))
set ylabel sprintf('k (10^{%d} m²)', power)
plot 'subsections.csv' skip 1 using (0.5*($1+$2)):($3/10**power):1:2 with xerrorbars lw 3 pt 0 lc rgb '#c07020', \
     permeability/10**power with lines lw 1 dt 2 lc rgb '#606060'
unset multiplot
