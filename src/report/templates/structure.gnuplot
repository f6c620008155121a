# Neighbours in contact, and the radial distribution of the centres: contacts.csv, radial_distribution.csv.
set datafile separator ','
set multiplot layout 1,2
unset key
set style fill solid 0.9
set boxwidth 0.8
set xlabel 'neighbours in contact'
set ylabel 'grains'
set yrange [0:*]
set xrange [-0.5:*]
plot 'contacts.csv' skip 1 using 1:2 with boxes lc rgb 0x2a6f9e
set xrange [0:*]
set xlabel 'distance of the centres (mm)'
set ylabel 'radial distribution'
plot 'radial_distribution.csv' skip 1 using (500*($1+$2)):3 with lines lw 2 lc rgb 0xc07020, 1 with lines dt 2 lc rgb 0x777777
unset multiplot
