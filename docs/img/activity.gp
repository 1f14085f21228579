# Activity of each element of the bellow in two scenes.
# Called by scripts/pictures with: tracking, step (CSV files of bgsim reduce --csv), picture (the SVG file).
set datafile separator comma
set terminal svg size 760,320 font "Helvetica,13" background rgb "white"
set output picture
set multiplot layout 1,2 margins 0.10,0.97,0.22,0.87 spacing 0.14
set style fill solid 0.9 noborder
set boxwidth 0.6
set yrange [4.6:-0.6]
set logscale x
set xrange [1e-6:2]
set xtics ("0.001 %%" 1e-5, "0.1 %%" 1e-3, "10 %%" 0.1)
set grid xtics lc rgb "#dddddd"
set ytics scale 0
set xlabel "share of activity"
unset key
set title "tracking: follows at 1 rad/s"
plot tracking using (column("share")):0:(1e-6):(column("share")):($0-0.3):($0+0.3):yticlabels(stringcolumn("element")) with boxxyerror lc rgb "#1f5f99"
set title "step: constant pressure from rest"
plot step using (column("share")):0:(1e-6):(column("share")):($0-0.3):($0+0.3):yticlabels(stringcolumn("element")) with boxxyerror lc rgb "#b8501e"
