#!/usr/bin/env bash
# Renders the pictures of the book into src/pictures. The drawings in src/drawings are written by hand.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --package enfilade-cli
program=${CARGO_TARGET_DIR:-target}/release/enfilade

# Figure, camera and methods. If a figure has two cameras, the camera is part of the file name.
while read -r figure camera methods; do
    name=$figure
    case $figure in overlap | cones-*) name=$figure-${camera//_/-} ;; esac
    for method in $methods; do
        "$program" draw "@$figure" --camera "${camera//_/ }" --method "$method" --size 480x360 --samples 4 \
            --output "book/src/pictures/$name-$method.png"
    done
done <<'FIGURES'
parallel-triangles front painter-min
parallel-rectangles front bsp
tetrahedron front painter-min painter-mean
wrong-winding front painter-min bsp
overlap mean_right painter-min painter-mean
overlap mean_wrong painter-mean bsp
crossing-triangles front painter-min painter-mean bsp
cycle front painter-min painter-mean bsp
triangle-through-cube corner painter-min painter-mean bsp
cylinders-8 front painter-mean
cylinders-16 front painter-mean
cylinders-32 front painter-mean
cones-8 base_seen painter-min
cones-8 base_hidden painter-min bsp
cones-32 base_hidden painter-min
four-cylinders from_above bsp
FIGURES

# The covers of one view of the palace; spans at a low resolution, so that each is visible. `--samples` is for images only.
while read -r cover method size; do
    "$program" draw @enfilade --camera enfilade --show cover --method "$method" --size "$size" \
        --output "book/src/pictures/cover-$cover.png"
done <<'COVERS'
spans hierarchical-s 480x270
pyramid hierarchical-z 960x540
tiles masked 960x540
tree svbsp 960x540
COVERS

# A tour of the palace. Underscores are spaces in the names of cameras.
while read -r picture camera; do
    "$program" draw @enfilade --camera "${camera//_/ }" --size 640x360 --samples 4 \
        --output "book/src/pictures/palace-$picture.png"
done <<'TOUR'
enfilade enfilade
facing-mirrors facing_mirrors
living-picture living_picture
dolls-house doll's_house
secret-passage secret_passage
bookcase bookcase
grotto grotto
fountain fountain
throne-room throne_room
red-salon red_salon
court court
gallery gallery
garden antechamber_window
pavilion pavilion
hill hill
tribune tribune
TOUR
"$program" draw @enfilade --show sectors --size 640x360 --output book/src/pictures/palace-sectors.png
"$program" draw @mirrors --size 480x270 --samples 4 --output book/src/pictures/lamp-mirrors.png
"$program" draw @teleport --size 480x270 --samples 4 --output book/src/pictures/lamp-teleport.png
for camera in bottles panes; do
    "$program" draw @bottles --camera "the $camera" --size 480x270 --samples 4 \
        --output "book/src/pictures/glass-$camera.png"
done

# A clip. The example writes it into its working directory.
cargo build --release --package enfilade_draw --example 06_hundred_people
(cd book/src/pictures && "$OLDPWD/target/release/examples/06_hundred_people")
