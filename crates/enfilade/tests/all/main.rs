//! Tests of the public API, beside the laws.

mod architecture;
mod baked_cells;
mod bodies;
mod choose;
mod cover_size;
mod degenerate;
mod detail;
mod draw_runs;
mod dynamic;
mod edits;
mod graph_edits;
mod kinds;
mod known;
mod large_terrain;
mod limits;
mod many_views;
mod moved;
mod parallel;
mod queries;
mod scene_errors;
mod send_sync;
mod shadows;
mod steps;
mod tightness;
mod without_occlusion;
