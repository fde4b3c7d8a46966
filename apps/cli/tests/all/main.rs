//! Tests of the program, each in its own process on a folder of its own.

#[path = "../../../../crates/enfilade_import/tests/all/quake/carved.rs"]
#[allow(dead_code, reason = "one map of one format is enough here")]
mod carved;
mod support;

mod bad_input;
mod bake;
mod bench;
mod choose;
mod compare;
mod draw;
mod help;
mod leaks;
mod link;
mod look;
mod look_report;
mod maps;
mod obj;
mod portals;
mod real_scenes;
mod rooms;
mod same_file;
mod saved;
mod scene_choice;
mod shards;
mod simd;
mod terrain;
mod unread;
mod upright;
mod view;
mod vis;
