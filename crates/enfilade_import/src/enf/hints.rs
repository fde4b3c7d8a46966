//! Prefetch hints: what is seen from a region of a room, by sampling. They order loading, and never filter.

use super::BakeError;
use super::container::{Container, Kind, Section, Source, Writer};
use super::read::{invalid, stored_scene};
use super::stored::StoredScene;
use crate::budget::Budget;
use crate::{BrokenRule, ImportError, ReadOptions};
use bytemuck::{Pod, Zeroable};
use enfilade::{Aabb, ItemIndex, SectorId};
use std::fs::File;
use std::io::{Seek, Write};
use std::path::Path;
use std::sync::Mutex;

/// The items that are seen from a region: a room, or a piece of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Hint {
    /// The room.
    pub sector: SectorId,
    /// The AABB of the region, in the space of the room.
    pub bounds: Aabb,
    /// The items, those seen from most positions first.
    pub items: Vec<(SectorId, ItemIndex)>,
}

/// A [`Hint`] in a file. Its items follow: the room and the index of each.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct HintRecord {
    sector: u32,
    bounds: [[f32; 3]; 2],
}

/// Reads the hints of a container.
pub(super) fn read_hints(
    container: &Container,
    scene: &StoredScene,
    budget: &mut Budget,
) -> Result<Vec<Hint>, BrokenRule> {
    let sections = (0..container.count(Kind::Hint)).map(|number| Section(Kind::Hint, number));
    let bytes = sections.map(|section| size_of::<Hint>() as u64 + 2 * container.length(section));
    budget.take(bytes.sum(), || "the hints".to_owned())?;
    let counts: Vec<u32> = scene.rooms.iter().map(|room| room.items).collect();
    let read = |number| {
        let section = Section(Kind::Hint, number);
        let bytes = container.section(section)?;
        Ok(decode(&bytes, &counts).map_err(|rule| invalid(section, rule))?)
    };
    (0..container.count(Kind::Hint)).map(read).collect()
}

/// Decodes the hint of a scene whose rooms have so many items each.
fn decode(bytes: &[u8], counts: &[u32]) -> Result<Hint, &'static str> {
    let split = bytes.split_at_checked(size_of::<HintRecord>());
    let (record, items) = split.ok_or("it ends within its box")?;
    let record: HintRecord = bytemuck::pod_read_unaligned(record);
    let [min, max] = record.bounds;
    if record.sector as usize >= counts.len() || min.iter().chain(&max).any(|value| value.is_nan()) {
        return Err("its region is in no room");
    }
    if !items.len().is_multiple_of(size_of::<[u32; 2]>()) {
        return Err("it ends within an item");
    }
    let items: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(items);
    let exists = |&[room, item]: &[u32; 2]| counts.get(room as usize).is_some_and(|&count| item < count);
    if !items.iter().all(exists) {
        return Err("an item does not exist");
    }
    Ok(Hint {
        sector: SectorId(record.sector),
        bounds: Aabb { min, max },
        items: (items.into_iter())
            .map(|[room, item]| (SectorId(room), ItemIndex(item)))
            .collect(),
    })
}

fn encode(hint: &Hint) -> Vec<u8> {
    let record = HintRecord {
        sector: hint.sector.0,
        bounds: [hint.bounds.min, hint.bounds.max],
    };
    let items: Vec<[u32; 2]> = (hint.items.iter()).map(|(room, item)| [room.0, item.0]).collect();
    [bytemuck::bytes_of(&record), bytemuck::cast_slice(&items)].concat()
}

/// Writes a baked scene with these hints, in place of those it has, to the start of `to`. Returns the number of bytes.
///
/// Write to a new file and rename it: readers map the file into memory, and expect that it does not change.
///
/// # Errors
/// Returns a [`BakeError`] if the file is no baked scene, or is damaged, a hint names what it does not have, or writing fails.
pub fn bake_hints(path: &Path, hints: &[Hint], to: impl Write + Seek) -> Result<u64, BakeError> {
    let failed = |rule| ImportError {
        file: path.display().to_string(),
        rule,
    };
    let open = || {
        let file = File::open(path).map_err(BrokenRule::Unreadable)?;
        let container = Container::open(Source::File(Mutex::new(file)))?;
        let scene = stored_scene(&container, &ReadOptions::default(), &mut Budget::new(u64::MAX))?;
        Ok((container, scene))
    };
    let (container, scene) = open().map_err(failed)?;
    let counts: Vec<u32> = scene.rooms.iter().map(|room| room.items).collect();
    let mut writer = Writer::new(to)?;
    for section in container.sections() {
        if section.0 != Kind::Hint {
            let bytes = container.section(section).map_err(failed)?;
            writer.section(section, &bytes)?;
        }
    }
    for (number, hint) in (0..).zip(hints) {
        let bytes = encode(hint);
        let section = Section(Kind::Hint, number);
        decode(&bytes, &counts).map_err(|rule| failed(invalid(section, rule).into()))?;
        writer.section(section, &bytes)?;
    }
    Ok(writer.finish()?)
}
