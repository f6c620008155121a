# Speed on a slice. Given: columns, rows, dx, dz, x0, z0 (mm), top (m/s). speed.bin: speeds as float; speed_solid.bin: colours of the cells
# without flow, red, green, blue and alpha.
set xlabel 'x (mm)'
set ylabel 'z (mm)'
set cblabel 'speed (mm/s)'
set cbrange [0:1e3*top]
# Nearly equal steps of lightness, so that it prints well.
set palette defined (0 '#450054', 0.25 '#3b528c', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fce824')
set size ratio -1
unset key
unset grid
set xrange [x0:x0+columns*dx]
set yrange [z0:z0+rows*dz]
form = sprintf('array=(%d,%d) dx=%.12g dy=%.12g origin=(%.12g,%.12g)', columns, rows, dx, dz, x0+dx/2, z0+dz/2)
eval "plot 'speed.bin' binary ".form." format='%float' using (1e3*$1) with image, 'speed_solid.bin' binary ".form." format='%uchar' using 1:2:3:4 with rgbalpha"
