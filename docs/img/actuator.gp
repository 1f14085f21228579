# The soft actuator bends: extension of both sides, pitch of the body, pressure of the pumps; and, in a window of its own,
# the start. Called by scripts/pictures with: trace, start (the CSV files of the scenes bending and start), picture (the
# SVG file).
set datafile separator comma
set terminal svg size 760,690 font "Helvetica,13" background rgb "white"
set output picture
set multiplot
set lmargin at screen 0.11
set rmargin at screen 0.80
panel(top, height) = sprintf("set tmargin at screen %g; set bmargin at screen %g", top, top - height)
set key at graph 1.02, graph 1 left top Left reverse samplen 2
set grid lc rgb "#dddddd"
set xrange [0:4*pi]
set xtics pi format ""
set style line 1 lw 2 lc rgb "#1f5f99"
set style line 2 lw 2 lc rgb "#b8501e"
set style line 3 lw 1.5 dt 3 lc rgb "#000000"

eval panel(0.98, 0.19)
set ylabel "extension (m)"
set ytics 0.2
plot trace using "t":"x_L" with lines ls 1 title "left", \
     trace using "t":"x_R" with lines ls 2 title "right", \
     trace using "t":"x_Lref" with lines ls 3 title "references", \
     trace using "t":"x_Rref" with lines ls 3 notitle
eval panel(0.76, 0.19)
set ylabel "pitch (rad)"
set ytics 0.5
plot trace using "t":"theta" with lines lw 2 lc rgb "#3b7d3b" title "body"
eval panel(0.54, 0.19)
set ylabel "pressure (kPa)"
set ytics 10
set yrange [-15:15]
set xtics ("0" 0, "π" pi, "2π" 2*pi, "3π" 3*pi, "4π" 4*pi) format "%g"
set xlabel "t (s)"
after(p) = column("t") > 0.15 ? p/1000 : NaN # what comes before is the last panel
plot trace using "t":(after(column("P1_L"))) with lines ls 1 title "left pump", \
     trace using "t":(after(column("P1_R"))) with lines ls 2 title "right pump"
eval panel(0.26, 0.18)
set ylabel "pressure (kPa)"
set yrange [-320:320]
set ytics 150
set xrange [0:150]
set xtics 25 format "%g"
set xlabel "t (ms): the start"
set style line 1 lw 1
plot start using (1000*column("t")):(column("P1_L")/1000) with lines ls 1 title "left pump"
