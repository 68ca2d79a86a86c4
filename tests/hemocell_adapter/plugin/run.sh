#!/usr/bin/env bash
# The plug-in in the stand-in of HemoCell: the same cells on any number of ranks and blocks, the same bytes as the program,
# complete across periodic faces, from and to states.
#   run.sh <test> <stand_in_case> <write_templates> <packMesh> <mpiexec> <cells' XML folder> <scratch folder>
set -euo pipefail
test=$1 stand_in=$2 templates=$3 program=$4 mpiexec=$5 xml=$6 scratch=$7
export OMPI_MCA_odls_base_sigkill_timeout=0 PRTE_MCA_odls_base_sigkill_timeout=0  # [s] that mpirun waits before it kills the others when a rank has failed, whether they end or not
await_all=$(realpath "$(dirname "$program")/await_all")
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch"
cp "$xml/RBC.xml" "$xml/PLT.xml" .
"$templates" 0.5 RBC PLT

config() { # nodes x, y, z, text of <packing>
  cat > config.xml << XML
<?xml version="1.0" ?>
<hemocell>
  <domain> <dx> 5e-7 </dx> <nx> $1 </nx> <ny> $2 </ny> <nz> $3 </nz> <particleEnvelope> 20 </particleEnvelope> </domain>
  <packing> $4 </packing>
</hemocell>
XML
}
case_on() { # ranks, then words
  local ranks=$1
  shift
  "$await_all" "$mpiexec" -n "$ranks" "$stand_in" "$@"
}
fail() {
  echo "$*"
  exit 1
}
same() { cmp "$1" "$2" || fail "$1 and $2 differ"; }
# Each cell has all its vertices once, under numbers that are the same up to multiples of the number of cells.
complete() { # expected cells
  awk -v cells="$1" '{ base = ($2 % cells + cells) % cells; key = base " " $3; if (key in seen) { print "twice: " $0; exit 1 }
    seen[key] = 1; count[base]++; type[base] = $1 }
    END { for (c in count) { all++; if (count[c] != (type[c] == 0 ? 642 : 66)) { print "cell " c " has " count[c]; exit 1 } }
          if (all != cells) { print all " cells of " cells; exit 1 } }' particles.txt
}

case $test in
  ranks)  # numbers of ranks and blocks change nothing; cells cross periodic faces
    for lumen in box planes pipe channel; do
      config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
      case_on 1 $lumen 1 1 1 | tee one.txt
      mv particles.txt one.particles
      case_on 2 $lumen 2 1 1 > two.txt
      grep '^(stand-in)' one.txt > a; grep '^(stand-in)' two.txt > b
      same a b
      # The numbers of wrapped cells and all positions are the same, whichever block has them.
      same one.particles particles.txt
      case_on 4 $lumen 2 2 3 > /dev/null
      same one.particles particles.txt
      complete "$(awk '/^\(stand-in\)/ { print $2 + $3 }' one.txt)"
      awk '$2 < 0 || $2 >= 10000 { wrapped++ } END { exit wrapped == 0 }' particles.txt || fail "$lumen: no cell crosses a periodic face"
      grep -q "fluid nodes.*whose volume the hematocrit refers to" one.txt
    done ;;
  bytes)  # the .pos files of the program for the same problems
    config 48 40 40 "<hematocrit> 0.30 </hematocrit> <walls> z </walls> <ends> periodic </ends>"
    "$program" config.xml > program.txt
    config 48 40 40 "<hematocrit> 0.30 </hematocrit> <hematocritVolume> fluid </hematocritVolume> <ends> periodic </ends>"  # as new-case writes
    case_on 2 planes 2 1 1 --output-dir plugin > plugin.txt
    same RBC.pos plugin/RBC.pos
    same PLT.pos plugin/PLT.pos
    config 48 40 40 "<hematocrit> 0.25 </hematocrit> <walls> z </walls> <method> cat </method>"
    "$program" config.xml > program.txt
    config 48 40 40 "<hematocrit> 0.25 </hematocrit>"
    case_on 2 planes 2 1 1 --method cat --ends closed --output-dir plugin > plugin.txt
    same RBC.pos plugin/RBC.pos
    same PLT.pos plugin/PLT.pos ;;
  soft)  # cells that deform, packed by the plug-in and loaded from the state
    config 48 40 40 "<hematocrit> 0.62 </hematocrit> <soft> true </soft>"
    case_on 2 box 2 1 1 --state soft.h5 > packed.txt
    grep -q 'Deformed cells: [0-9]*; largest force on a vertex' packed.txt
    complete "$(awk '/^\(stand-in\)/ { print $2 + $3 }' packed.txt)"
    case_on 1 box 1 1 1 load soft.h5 > loaded.txt
    complete "$(awk '/^\(stand-in\)/ { print $2 + $3 }' packed.txt)"
    # In the nodes of a capillary: they keep off the steps of the wall, on any number of ranks.
    config 60 44 44 "<hematocrit> 0.30 </hematocrit> <soft> true </soft> <species name='RBC'/>"
    case_on 1 capillary 1 1 1 > one.txt
    mv particles.txt one.particles
    case_on 2 capillary 2 1 1 > /dev/null
    same one.particles particles.txt
    complete "$(awk '/^\(stand-in\)/ { print $2 + $3 }' one.txt)"
    grep -q 'largest force on a vertex [0-4]\.' one.txt || fail "the force is large"
    awk '{ y = int($5 + 0.5) - 21.5; z = int($6 + 0.5) - 21.5; if (y * y + z * z > 25) out = 1 } END { exit out }' one.particles || fail "a vertex is on a solid node" ;;
  lumen)  # a lumen that is described in <packing>: its volume, its wall, and HemoCell's nodes
    config 60 44 44 "<hematocrit> 0.25 </hematocrit> <ends> periodic </ends>
      <container> <cylinder axis='x' radius='10' length='30' center='14.75 10.75 10.75'/> <nodes> 60 44 44 </nodes> </container>"
    "$program" config.xml > program.txt
    case_on 2 pipe 2 1 1 --output-dir plugin > plugin.txt
    same RBC.pos plugin/RBC.pos
    same PLT.pos plugin/PLT.pos
    grep -q 'the hematocrit refers to the lumen' plugin.txt ;;
  growth)  # in nodes that are no box
    config 60 44 44 ""
    case_on 1 channel 1 1 1 --method cat --hematocrit 0.15 > one.txt
    mv particles.txt one.particles
    case_on 2 channel 2 2 1 --method cat --hematocrit 0.15 > /dev/null
    same one.particles particles.txt ;;
  tetgen)  # packmesh-tetgen is found from the plug-in; whatever happens to it, the cells are packed
    config 48 40 40 "<method> cat </method>"
    case_on 2 planes 2 1 1 --rbc 15 --builder cat-faces > said.txt
    mv particles.txt faces.particles
    real=$(realpath "$(dirname "$program")/../libexec/packmesh/packmesh-tetgen")
    for fault in 'kill -9 $$' "ulimit -v 4000; exec '$real'" 'head -c 100000 /dev/urandom >&3' "exec '$real' 3< /dev/urandom"; do
      printf '#!/bin/sh\n[ "$1" = --version ] && exec "%s" --version\necho >> "%s"\n%s\n' "$real" "$PWD/runs" "$fault" > packmesh-tetgen
      chmod +x packmesh-tetgen
      PACKMESH_TETGEN=$PWD/packmesh-tetgen case_on 2 planes 2 1 1 --rbc 15 --builder cat-faces > said.txt
      test -s runs && rm runs
      grep -q 'Certificate: clean, no overlap (15 cells' said.txt
      if cmp -s faces.particles particles.txt; then fail "planes of CAT faces without TetGen"; fi
      test -e failing.particles || cp particles.txt failing.particles
      same failing.particles particles.txt
    done
    if PACKMESH_TETGEN=/no/such/program case_on 2 planes 2 1 1 --rbc 15 --builder cat-faces > said.txt 2>&1; then fail "accepted"; fi
    test "$(grep -c "(Error).*PACKMESH_TETGEN is '/no/such/program'" said.txt)" = 1 ;;
  counts)
    config 60 44 44 "<hematocrit> 0.4 </hematocrit>"
    case_on 1 pipe 1 1 1 nodes 1000 --count PLT 30 > said.txt 2> warned.txt
    grep -q '^(stand-in) [0-9]* 30$' said.txt
    grep -q 'mostNodesOnEveryRank has no effect' warned.txt ;;
  inlet)  # one rank has no cells, and all know their number
    config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
    case_on 3 inlet 2 1 1 > three.txt
    mv particles.txt three.particles
    case_on 2 inlet 1 1 1 > two.txt
    same three.particles particles.txt
    grep -q "HemoCell's pre-inlet" two.txt
    awk '$4 < 19.5 || $4 > 69.5 { exit 1 }' particles.txt || fail "a vertex is not in the inlet" ;;
  state)  # written, loaded, saved, loaded, checked, started from
    config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
    case_on 2 pipe 2 1 1 --state cells.h5 > packed.txt
    mv particles.txt packed.particles
    # Files beside it that HemoCell's loader would read, and that are of another run, are named.
    case_on 2 pipe 2 1 1 --output-dir . --state files.h5 > packed.txt
    case_on 2 pipe 2 1 1 load files.h5 > said.txt 2>&1
    if grep 'beside it' said.txt; then fail "they are of this run"; fi
    printf '1\n15 11 11 0 0 0\n' > RBC.pos
    case_on 2 pipe 2 1 1 load files.h5 > said.txt 2>&1
    grep -q 'files.h5: RBC.pos beside it was not written together with it, and not loaded' said.txt
    rm ./*.pos
    case_on 3 pipe 3 1 1 load cells.h5 fit saved.h5 > loaded.txt
    same packed.particles particles.txt
    grep -q 'rigid fits with residuals up to 0.0000' loaded.txt
    case_on 2 pipe 2 1 1 load saved.h5 > again.txt
    grep -q 'packing starts from them' again.txt
    # The same cells: poses differ by rounding.
    paste packed.particles particles.txt | awk '{ for (k = 4; k <= 6; ++k) { d = $k - $(k + 6); if (d < 0) d = -d; if (d > 1e-6) bad++ } }
      END { exit bad > 0 }' || fail "cells moved"
    config 60 44 44 "<container> <cylinder axis='x' radius='10.5' length='30' center='14.75 10.75 10.75'/> <nodes> 60 44 44 </nodes> </container>"
    status=0
    "$program" check config.xml --start saved.h5 --ends periodic > check.txt || status=$?
    grep -q 'RBC: [0-9]* cells' check.txt || grep -q 'cells' check.txt
    test $status -eq 0 -o $status -eq 4
    "$program" config.xml --ends periodic --fixed cells.h5 --plt 25 > more.txt
    test "$(head -n 1 PLT.pos)" = 25 ;;
  deformed)  # cells of a run are added as they were, on any ranks and blocks, and the program packs around them
    config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
    case_on 2 pipe 2 1 1 deform --clearance 0.2 save flowing.h5 > saved.txt
    grep -q 'cells as they were' saved.txt
    mv particles.txt saved.particles
    for layout in "1 1 1 1" "3 3 1 1" "4 2 2 3"; do
      # shellcheck disable=SC2086
      set -- $layout
      case_on "$1" pipe "$2" "$3" "$4" load flowing.h5 > loaded.txt
      complete "$(awk '/^\(stand-in\)/ { print $2 + $3 }' loaded.txt)"
      paste saved.particles particles.txt | awk '{ for (k = 1; k <= 3; ++k) if ($k != $(k + 6)) bad++
          for (k = 4; k <= 6; ++k) { d = $k - $(k + 6); if (d < 0) d = -d; if (d > 1e-9) bad++ } }
        END { exit bad > 0 || NR == 0 }' || fail "vertices moved on $1 ranks"
    done
    # One that intersects itself is added as it is, and named.
    case_on 2 pipe 2 1 1 deform cross --clearance 0.3 --hematocrit 0.1 save crossed.h5 > crossed.txt
    for ranks in 1 3; do
      case_on $ranks pipe $ranks 1 1 load crossed.h5 > loaded.txt 2>&1
      grep -qE "crossed.h5: 1 of its [0-9]+ cells 'RBC' intersects itself, the first near \([^)]*\) µm; it is added as it is" loaded.txt
      complete "$(awk '/^\(stand-in\)/ { print $2 + $3 }' crossed.txt)"
    done
    # Of a packing that was not finished they are packed on, whether or not they have meshes of their own.
    config 60 44 44 "<container> <cylinder axis='x' radius='10.5' length='30' center='14.75 10.75 10.75'/> <nodes> 60 44 44 </nodes> </container>"
    status=0
    "$program" config.xml --ends periodic --blood flowing.h5 --rbc 36 --plt 2 --clearance 0.3 --max-iterations 1 --state dense.h5 > dense.txt || status=$?
    test $status = 3 -a ! -e dense.h5
    config 60 44 44 ""
    case_on 2 pipe 2 1 1 load dense.checkpoint.h5 > loaded.txt
    grep -q 'dense.checkpoint.h5: [1-9][0-9]* pairs\? of its cells overlaps\?; packing starts from them' loaded.txt
    grep -q 'Certificate: clean' loaded.txt
    complete 38
    config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
    # Loaded into another lumen, whose wall nodes some vertices are on: refused, or without these cells, which HemoCell would delete.
    all=$(awk '/^\(stand-in\)/ { print $2 + $3 }' saved.txt)
    for ranks in 1 2; do
      if case_on $ranks channel $ranks 1 1 load flowing.h5 > said.txt 2>&1; then fail "accepted"; fi
      grep -oE "flowing.h5: HemoCell would delete [0-9]+ of its $all cells: RBC [0-9]+ at \([^)]*\) µm: a vertex lies on a wall node; .*" \
        said.txt > refused.$ranks || fail "cells are not named"
      case_on $ranks channel $ranks 1 1 load flowing.h5 leave-out > left.txt 2>&1
      deleted=$(sed -nE 's/.*HemoCell would delete ([0-9]+) of its .*they are left out/\1/p' left.txt)
      test "$deleted" -gt 0 -a "$deleted" -lt "$all"
      test "$(awk '/^\(stand-in\)/ { print $2 + $3 }' left.txt)" = $((all - deleted))
      complete $((all - deleted))
    done
    same refused.1 refused.2
    config 60 44 44 "<container> <cylinder axis='x' radius='10.5' length='30' center='14.75 10.75 10.75'/> <nodes> 60 44 44 </nodes> </container>"
    "$program" config.xml --ends periodic --fixed flowing.h5 --plt 25 > more.txt 2>&1
    grep -q 'Certificate: clean' more.txt
    # They cross the periodic faces, and are loaded from the state.
    grep -q 'With loadParticles() HemoCell keeps \([0-9]*\) of \1 cells' more.txt
    if grep -q 'HemoCell would keep' more.txt; then fail "advice for .pos files"; fi
    "$program" check config.xml --ends periodic --start flowing.h5 > check.txt
    grep -q 'With loadParticles() HemoCell keeps \([0-9]*\) of \1 RBC' check.txt
    if grep -q 'will delete' check.txt; then fail "the plug-in keeps cells across periodic faces"; fi
    grep -q 'RBC.pos is not written: its cells are deformed.*state.h5' more.txt
    # The plug-in packs around them, too, and loads deformed and undeformed cells alike.
    config 60 44 44 ""
    case_on 2 pipe 2 1 1 --fixed flowing.h5 --plt 25 --state mixed.h5 > more.txt
    grep -q '^(stand-in) [0-9]* 25$' more.txt
    mv particles.txt mixed.particles
    case_on 3 pipe 3 1 1 load mixed.h5 > loaded.txt
    paste mixed.particles particles.txt | awk '{ for (k = 4; k <= 6; ++k) { d = $k - $(k + 6); if (d < 0) d = -d; if (d > 1e-9) bad++ } }
      END { exit bad > 0 || NR == 0 }' || fail "vertices moved" ;;
  watch)  # cells that become longer than the envelope are named before HemoCell deletes them, alike on any ranks and blocks
    config 60 44 44 "<hematocrit> 0.2 </hematocrit>"
    case_on 1 pipe 1 1 1 stretch 60 > one.txt 2> one.err
    for ranks in 2 4; do
      case_on $ranks pipe $ranks 1 1 stretch 60 > more.txt 2> more.err
      for file in one more; do grep '^(stand-in) [0-9]*: .* 0 too long' $file.txt > $file.before; done
      same one.before more.before
      grep -m 1 '(Warning) iteration' one.err > one.first
      grep -m 1 '(Warning) iteration' more.err > more.first
      same one.first more.first
    done
    test -s one.before
    grep -qE 'iteration [0-9]+: RBC [0-9]+ is 19\.[0-9] nodes \(9\.[0-9]+ µm\) long along x, <particleEnvelope> is 20' one.first
    grep -q '<particleEnvelope> 44 </particleEnvelope>' one.err
    grep -q 'the smallest block is now 15 x 44 x 44' more.err  # of 4 ranks
    # Afterwards some are lost, and this is said, too.
    warned=$(sed -nE 's/.*iteration ([0-9]+): RBC.*/\1/p' more.err | head -n 1)
    lost=$(sed -nE 's/.*iteration ([0-9]+): HemoCell has deleted cells: [0-9]+ of [0-9]+ cells \([0-9]+ RBC, [0-9]+ PLT\) are left/\1/p' more.err | head -n 1)
    test "$warned" -lt "$lost" || fail "warned at $warned, lost at $lost"
    status=0
    case_on 2 pipe 2 1 1 stretch 60 stop > said.txt 2>&1 || status=$?
    test $status = 70 || fail "exit code $status"
    test "$(grep -c '(Error)' said.txt)" = 1
    if grep 'has deleted' said.txt; then fail "too late"; fi
    # With a pre-inlet, ranks without its cells know the same.
    case_on 3 inlet 2 1 1 stretch 30 > inlet.txt 2> inlet.err
    if grep 'ranks differ' ./*.txt; then fail "ranks differ"; fi
    grep -q '(Warning) iteration' inlet.err
    grep -q '^(stand-in) 30: .* [1-9][0-9]* too long' inlet.txt
    # Two periodic axes, blocks along all: images of a cell are one cell.
    config 48 40 40 "<hematocrit> 0.2 </hematocrit>"
    case_on 2 box 2 2 2 stretch 5 > said.txt 2>&1
    case_on 1 box 1 1 1 stretch 5 > one.txt 2>&1
    for file in said one; do grep '^(stand-in) [0-9]*: .* 0 too long' $file.txt > $file.watched; done
    same said.watched one.watched
    test "$(wc -l < one.watched)" = 5 ;;
  checkpoint)  # a restart keeps the cells across periodic faces, whatever .pos files there are
    config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
    case_on 2 pipe 2 1 1 checkpoint > packed.txt
    mv particles.txt packed.particles
    cells=$(awk '/^\(stand-in\)/ { print $2 + $3 }' packed.txt)
    test "$(cat RBC.pos PLT.pos | awk '{ s += $1 } END { print s }')" = "$cells"
    same RBC.pos checkpoint/RBC.pos
    for restart in own plugin; do  # HemoCell's loadCheckPoint(), and the plug-in's
      for ranks in 1 2 3; do
        case_on $ranks pipe $ranks 1 1 config checkpoint/checkpoint.xml restart $restart > restarted.txt
        same packed.particles particles.txt
      done
    done
    # Counts of another run in the same folder, and files with cells: the plug-in's restart keeps all cells.
    rm RBC.pos
    case_on 2 pipe 2 1 1 config checkpoint/checkpoint.xml restart own > restarted.txt
    if cmp -s packed.particles particles.txt; then fail "HemoCell needs no RBC.pos"; fi  # else this tests nothing
    case_on 2 pipe 2 1 1 config checkpoint/checkpoint.xml restart plugin > restarted.txt
    same packed.particles particles.txt
    printf '1\n5 5 5 0 0 0\n' > RBC.pos
    case_on 2 pipe 2 1 1 config checkpoint/checkpoint.xml restart plugin > restarted.txt
    same packed.particles particles.txt
    case_on 2 pipe 2 1 1 > packed.txt 2>&1
    grep -q 'RBC.pos announces 1, .* were added.*call packmesh::loadCheckPoint(hemocell) instead' packed.txt
    test "$(wc -l < RBC.pos)" = 2 || fail "a file with cells was replaced"
    # Another run in the same folder keeps the numbers of the checkpoint that is there.
    config 60 44 44 "<hematocrit> 0.15 </hematocrit>"
    cp checkpoint/RBC.pos numbers.pos
    case_on 2 pipe 2 1 1 > packed.txt 2>&1
    grep -q 'checkpoint of another run, whose numbers of cells are now in .*RBC.pos.old' packed.txt
    same numbers.pos checkpoint/RBC.pos.old
    # Nobody knows the number: an error before a cell is deleted.
    rm RBC.pos checkpoint/RBC.pos
    status=0
    case_on 2 pipe 2 1 1 config checkpoint/checkpoint.xml restart plugin > said.txt 2>&1 || status=$?
    test $status = 2
    grep -q 'number of cells of the checkpoint is unknown' said.txt ;;
  exchange)  # decompositions in which HemoCell loses cells at periodic faces
    config 60 44 44 "<hematocrit> 0.2 </hematocrit>"
    # The plug-in warns where HemoCell's exchange loses cells, verifyParticles() finds them, and the proposed correction keeps all.
    loses() { # expected, then ranks, lumen, blocks
      local expected=$1 said=no lost=no
      shift
      case_on "$@" copies > said.txt 2>&1 || fail "$*: the correction loses cells"
      case_on "$@" shifts > said.txt 2>&1 || lost=yes
      if [[ $lost = yes ]]; then
        grep -q 'deleted cells before the end of iteration 1 that were packed.*Was a vertex on a wall node, or did it move there?' said.txt
      fi
      if grep -q 'HemoCell 2.7 can delete cells at periodic faces' said.txt; then said=yes; fi
      test $said = "$expected" -a $lost = "$expected" || fail "$*: warned: $said, lost cells: $lost"
    }
    loses no 1 planes 2 2 1
    loses no 2 planes 1 1 2  # each block spans both periods
    loses no 2 pipe 2 1 1
    loses no 2 pipe 1 2 1
    loses no 4 pipe 2 2 1
    loses yes 3 planes 3 1 1
    loses yes 2 planes 1 2 1
    loses yes 4 planes 2 2 1
    loses yes 2 box 2 1 1
    loses yes 2 pipe 4 1 1
    grep -q 'several atomic blocks per rank on 2 ranks.*one atomic block per rank' said.txt
    loses yes 2 planes 2 1 1
    grep -q 'with 2 periodic axes on 2 ranks.*one rank.*setSystemPeriodicity' said.txt
    config 60 44 44 "<hematocrit> 0.2 </hematocrit>"
    if case_on 2 pipe 2 1 1 lose > said.txt 2>&1; then fail "a vertex is missing, and nothing was said"; fi
    grep -q 'deleted cells before the end of iteration 1 that were packed: 1 of [0-9]* RBC' said.txt
    if case_on 2 pipe 2 1 1 double > said.txt 2>&1; then fail "a vertex is there twice, and nothing was said"; fi
    grep -q 'HemoCell has more vertices before the end of iteration 1 than were packed: 1 of RBC' said.txt ;;
  spacing)  # a state of another lattice spacing is the start of a packing
    config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
    case_on 2 pipe 2 1 1 --state cells.h5 > packed.txt
    "$templates" 0.4 RBC PLT
    config 75 55 55 ""
    sed -i 's/5e-7/4e-7/' config.xml
    case_on 2 pipe 2 1 1 load cells.h5 > loaded.txt
    grep -q "HemoCell builds another template of '.*', as at another lattice spacing; packing starts from them" loaded.txt
    grep -q 'Certificate: clean' loaded.txt
    test "$(grep '^(stand-in)' packed.txt)" = "$(grep '^(stand-in)' loaded.txt)" ;;
  place)  # messages about <packing> name the file that was given, and the line
    printf '%s\n' '<?xml version="1.0" ?>' '<!-- a case' '  of two lines -->' '<hemocell>' '<domain>' \
      '  <dx> 5e-7 </dx> <nx> 60 </nx>' '' '  <ny> 44 </ny> <nz> 44 </nz> <!-- more' ' --> <particleEnvelope> 20 </particleEnvelope>' \
      '</domain>' '<packing>' '  <hematocrit> many </hematocrit>' '</packing>' '</hemocell>' > case.xml
    config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
    status=0
    case_on 2 pipe 2 1 1 config case.xml > said.txt 2>&1 || status=$?
    test $status = 2
    grep -q '(Error) case.xml:12: <hematocrit>' said.txt
    rm config.xml
    cp case.xml config.xml  # not on the command line
    case_on 1 pipe 1 1 1 > said.txt 2>&1 && fail "accepted"
    grep -q '(Error) config.xml:12: <hematocrit>' said.txt ;;
  exceptions)  # that the case can catch, on all ranks
    config 60 44 44 ""
    case_on 3 pipe 3 1 1 catch > said.txt 2>&1
    test "$(grep -c '^(stand-in) rank [012] caught, exit code 1: .*how many cells' said.txt)" = 3
    config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
    case_on 3 inlet 2 1 1 catch --count XYZ 3 > said.txt 2>&1  # one rank has no cells
    test "$(grep -c "^(stand-in) rank [012] caught.*no cell type 'XYZ'" said.txt)" = 3
    case_on 2 pipe 2 1 1 catch lose > said.txt 2>&1
    test "$(grep -c '^(stand-in) rank [01] caught, exit code 70' said.txt)" = 2 ;;
  errors)
    config 60 44 44 "<hematocrit> 0.25 </hematocrit>"
    if case_on 2 pipe 2 1 1 short > said.txt 2>&1; then fail "cells are missing, and nothing was said"; fi
    grep -q 'HemoCell deleted cells that were packed: .* of .* RBC' said.txt
    grep -q particleEnvelope said.txt
    if case_on 2 pipe 2 1 1 --hematocrit 0.55 --max-time 0.1 > said.txt 2>&1; then fail "accepted"; fi
    test "$(grep -c '(Error)' said.txt)" = 1
    if case_on 2 pipe 2 1 1 --count XYZ 3 > said.txt 2>&1; then fail "accepted"; fi
    grep -q "no cell type 'XYZ'; it has RBC and PLT" said.txt
    # Members of PackingOptions, and options in `more`, are named as such.
    if case_on 1 pipe 1 1 1 member hematocrit 2 > said.txt 2>&1; then fail "accepted"; fi
    grep -q '(Error) PackingOptions::hematocrit: expected a number in \[0, 1)' said.txt
    if case_on 1 pipe 1 1 1 --count RBC -3 > said.txt 2>&1; then fail "accepted"; fi
    grep -q '(Error) PackingOptions::counts\["RBC"\]: expected a whole number' said.txt
    if case_on 1 pipe 1 1 1 --max-time -1 > said.txt 2>&1; then fail "accepted"; fi
    grep -q "(Error) option '--max-time': expected" said.txt
    if case_on 1 pipe 1 1 1 load nothing.h5 > said.txt 2>&1; then fail "accepted"; fi
    grep -q 'nothing.h5' said.txt
    config 60 44 44 ""
    if case_on 1 pipe 1 1 1 > said.txt 2>&1; then fail "accepted"; fi
    grep -q 'how many cells' said.txt ;;
  *) fail "no test $test" ;;
esac
