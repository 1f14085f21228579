# The soft actuator bends: extension of both sides, pitch of the body, pressure of the pumps.
# Called by scripts/pictures with: trace (the CSV file), picture (the SVG file).
set datafile separator comma
set terminal svg size 760,520 font "Helvetica,13" background rgb "white"
set output picture
set multiplot layout 3,1 margins 0.11,0.80,0.13,0.97 spacing 0.045
set key outside right top Left reverse samplen 2
set grid lc rgb "#dddddd"
set xrange [0:4*pi]
set xtics pi format ""
set style line 1 lw 2 lc rgb "#1f5f99"
set style line 2 lw 2 lc rgb "#b8501e"
set style line 3 lw 1.5 dt 3 lc rgb "#000000"

set ylabel "extension (m)"
set ytics 0.2
plot trace using "t":"x_L" with lines ls 1 title "left", \
     trace using "t":"x_R" with lines ls 2 title "right", \
     trace using "t":"x_Lref" with lines ls 3 title "references", \
     trace using "t":"x_Rref" with lines ls 3 notitle
set ylabel "pitch (rad)"
set ytics 0.5
plot trace using "t":"theta" with lines lw 2 lc rgb "#3b7d3b" title "body"
set ylabel "pressure (kPa)"
set ytics 10
set yrange [-15:15] # the pumps begin at 300 kPa for some milliseconds: the references do not start from rest
set xtics ("0" 0, "π" pi, "2π" 2*pi, "3π" 3*pi, "4π" 4*pi) format "%g"
set xlabel "t (s)"
plot trace using "t":(column("P1_L")/1000) with lines ls 1 title "left pump", \
     trace using "t":(column("P1_R")/1000) with lines ls 2 title "right pump"
