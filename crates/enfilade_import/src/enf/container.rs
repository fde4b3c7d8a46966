//! The container of baked scenes: sections with checksums, and a table of them.
//!
//! Layout, all little-endian: [`Header`], the sections, each aligned to [`ALIGNMENT`], and the table: an [`Entry`] for each
//! section, in the order of the sections. A section is identified by its kind and its number among those of the kind. The
//! checksums are xxh3 of 64 bits.
//! Source: xxHash, Collet.
//! Cost: opening reads the header and the table.

use super::{EnfError, SectionTotal};
use crate::BrokenRule;
use bytemuck::{Pod, Zeroable};
use bytes::Bytes;
use std::fmt;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

pub(super) const MAGIC: [u8; 8] = *b"ENFILADE";

/// Change it with every change of what is stored, meshes included: a test compares the bytes of a baked scene.
pub(super) const VERSION: u32 = 3;

/// Sections start at multiples of this: cache lines.
const ALIGNMENT: u64 = 64;

/// The kinds of sections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Kind {
    /// Rooms, portals, materials, cameras, lights: a [`StoredScene`](super::stored::StoredScene) as MessagePack.
    Scene = 1,
    /// A [`MeshRecord`](super::stored::MeshRecord) for each mesh.
    Meshes = 2,
    /// An [`ItemRecord`](super::stored::ItemRecord) for each item, room after room.
    Items = 3,
    /// The names of all items, one after another.
    Names = 4,
    /// Meshes that are near each other, as [`Mesh::to_bytes`](enfilade::Mesh::to_bytes).
    Page = 5,
    /// A texture, as PNG.
    Image = 6,
    /// What the scene was baked from, in the words of the program that baked it.
    Source = 7,
    /// What is seen from a region of a room: see [`Hint`](super::Hint).
    Hint = 8,
    /// Coarser meshes of those of the page of the same number, as in the page.
    Level = 9,
}

impl Kind {
    const ALL: [Kind; 9] = [
        Kind::Scene,
        Kind::Meshes,
        Kind::Items,
        Kind::Names,
        Kind::Page,
        Kind::Image,
        Kind::Source,
        Kind::Hint,
        Kind::Level,
    ];

    fn name(self) -> &'static str {
        match self {
            Kind::Scene => "scene",
            Kind::Meshes => "meshes",
            Kind::Items => "items",
            Kind::Names => "names",
            Kind::Page => "page",
            Kind::Image => "image",
            Kind::Source => "source",
            Kind::Hint => "hint",
            Kind::Level => "level",
        }
    }
}

/// A section: its kind, and its number among those of this kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Section(pub(super) Kind, pub(super) u32);

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Section(kind, number) = self;
        match kind {
            Kind::Page | Kind::Image | Kind::Hint | Kind::Level => write!(f, "{} {number}", kind.name()),
            _ => f.write_str(kind.name()),
        }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Header {
    magic: [u8; 8],
    version: u32,
    sections: u32,
    /// Where the table starts; the file ends with it.
    table: u64,
    file_length: u64,
    table_checksum: u64,
    reserved: [u64; 2],
    /// Of the header before it.
    checksum: u64,
}

const HEADER: usize = size_of::<Header>();

impl Header {
    fn sum(&self) -> u64 {
        xxh3_64(&bytemuck::bytes_of(self)[..HEADER - size_of::<u64>()])
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Entry {
    kind: u32,
    number: u32,
    offset: u64,
    length: u64,
    checksum: u64,
}

impl Entry {
    fn section(&self) -> (u32, u32) {
        (self.kind, self.number)
    }
}

/// Writes a container, section after section.
pub(super) struct Writer<W> {
    to: W,
    /// Bytes written so far.
    at: u64,
    entries: Vec<Entry>,
}

impl<W: Write + Seek> Writer<W> {
    /// Writes to the start of `to`.
    pub(super) fn new(mut to: W) -> io::Result<Writer<W>> {
        to.seek(SeekFrom::Start(0))?;
        to.write_all(&[0; HEADER])?;
        let at = HEADER as u64;
        Ok(Writer {
            to,
            at,
            entries: Vec::new(),
        })
    }

    /// Writes a section; each once, in any order.
    pub(super) fn section(&mut self, Section(kind, number): Section, bytes: &[u8]) -> io::Result<()> {
        self.align()?;
        self.entries.push(Entry {
            kind: kind as u32,
            number,
            offset: self.at,
            length: bytes.len() as u64,
            checksum: xxh3_64(bytes),
        });
        self.put(bytes)
    }

    /// Writes the table and the header. Returns the length of the file.
    pub(super) fn finish(mut self) -> io::Result<u64> {
        self.align()?;
        let table = self.at;
        let entries = std::mem::take(&mut self.entries);
        let bytes: &[u8] = bytemuck::cast_slice(&entries);
        self.put(bytes)?;
        let mut header = Header {
            magic: MAGIC,
            version: VERSION,
            sections: entries.len() as u32,
            table,
            file_length: self.at,
            table_checksum: xxh3_64(bytes),
            reserved: [0; 2],
            checksum: 0,
        };
        header.checksum = header.sum();
        self.to.seek(SeekFrom::Start(0))?;
        self.to.write_all(bytemuck::bytes_of(&header))?;
        self.to.flush()?;
        Ok(self.at)
    }

    fn align(&mut self) -> io::Result<()> {
        let padding = self.at.next_multiple_of(ALIGNMENT) - self.at;
        self.put(&[0; ALIGNMENT as usize][..padding as usize])
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.to.write_all(bytes)?;
        self.at += bytes.len() as u64;
        Ok(())
    }
}

/// Where the bytes of a container are.
pub(super) enum Source {
    /// In memory, or mapped into it. Sections are used in place.
    Memory(Bytes),
    /// In a file. Sections are copied when they are read, so that dropping them frees their memory.
    File(Mutex<File>),
}

impl Source {
    fn length(&self) -> io::Result<u64> {
        match self {
            Source::Memory(bytes) => Ok(bytes.len() as u64),
            Source::File(file) => Ok(unpoisoned(file).metadata()?.len()),
        }
    }

    /// Returns a range of bytes, which must lie in the file.
    fn read(&self, offset: u64, length: u64) -> io::Result<Bytes> {
        match self {
            Source::Memory(bytes) => Ok(bytes.slice(offset as usize..(offset + length) as usize)),
            Source::File(file) => {
                let mut bytes = Vec::new();
                let length = usize::try_from(length).map_err(|_| io::ErrorKind::OutOfMemory)?;
                bytes
                    .try_reserve_exact(length)
                    .map_err(|_| io::ErrorKind::OutOfMemory)?;
                bytes.resize(length, 0);
                let mut file = unpoisoned(file);
                file.seek(SeekFrom::Start(offset))?;
                file.read_exact(&mut bytes)?;
                Ok(bytes.into())
            }
        }
    }
}

fn unpoisoned(file: &Mutex<File>) -> MutexGuard<'_, File> {
    file.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A container whose header and table are checked. Sections are checked as they are read.
pub(super) struct Container {
    source: Source,
    entries: Vec<Entry>,
}

impl Container {
    /// Checks the header and the table.
    pub(super) fn open(source: Source) -> Result<Container, BrokenRule> {
        let has = source.length().map_err(BrokenRule::Unreadable)?;
        let needs = HEADER as u64;
        if has < needs {
            return Err(EnfError::Truncated { needs, has }.into());
        }
        let read = |offset, length| source.read(offset, length).map_err(BrokenRule::Unreadable);
        let header: Header = bytemuck::pod_read_unaligned(&read(0, needs)?);
        if header.version != VERSION {
            return Err(EnfError::Version(header.version).into());
        }
        let damaged = |section: &'static str| EnfError::Damaged(section.to_owned());
        if header.checksum != header.sum() || header.magic != MAGIC {
            return Err(damaged("header").into());
        }
        let needs = header.file_length;
        if needs != has {
            return Err(EnfError::Truncated { needs, has }.into());
        }
        let length = u64::from(header.sections) * size_of::<Entry>() as u64;
        if header.table.checked_add(length) != Some(has) {
            return Err(damaged("table of sections").into());
        }
        let table = read(header.table, length)?;
        if xxh3_64(&table) != header.table_checksum {
            return Err(damaged("table of sections").into());
        }
        let mut entries: Vec<Entry> = bytemuck::pod_collect_to_vec(&table);
        let mut last = HEADER as u64;
        for entry in &entries {
            let end = entry.offset.checked_add(entry.length);
            let end = end.filter(|&end| entry.offset >= last && end <= header.table);
            last = end.ok_or(damaged("table of sections"))?;
        }
        entries.sort_by_key(Entry::section);
        if entries
            .windows(2)
            .any(|pair| pair[0].section() == pair[1].section())
        {
            return Err(damaged("table of sections").into());
        }
        Ok(Container { source, entries })
    }

    /// Returns a section, whose checksum is correct.
    pub(super) fn section(&self, section: Section) -> Result<Bytes, BrokenRule> {
        let damaged = || EnfError::Damaged(section.to_string());
        let entry = self.entry(section).ok_or_else(damaged)?;
        let bytes = self
            .source
            .read(entry.offset, entry.length)
            .map_err(BrokenRule::Unreadable)?;
        if xxh3_64(&bytes) != entry.checksum {
            return Err(damaged().into());
        }
        Ok(bytes)
    }

    /// Returns at most `length` bytes of a section, from `start`, without checking the checksum: for estimates only.
    pub(super) fn beginning(&self, section: Section, start: u64, length: usize) -> Result<Bytes, BrokenRule> {
        let entry = self
            .entry(section)
            .ok_or_else(|| EnfError::Damaged(section.to_string()))?;
        let start = start.min(entry.length);
        let length = (entry.length - start).min(length as u64);
        let bytes = self.source.read(entry.offset + start, length);
        bytes.map_err(BrokenRule::Unreadable)
    }

    /// Returns the length of a section, in bytes; 0 if it does not exist.
    pub(super) fn length(&self, section: Section) -> u64 {
        self.entry(section).map_or(0, |entry| entry.length)
    }

    /// Returns the length of all sections of other kinds, in bytes.
    pub(super) fn length_without(&self, kinds: [Kind; 2]) -> u64 {
        let is_other = |entry: &&Entry| kinds.iter().all(|&kind| entry.kind != kind as u32);
        let others = self.entries.iter().filter(is_other);
        others.map(|entry| entry.length).sum()
    }

    /// Returns a hash of all sections of other kinds.
    pub(super) fn hash_without(&self, kind: Kind) -> u64 {
        let mut hash = Xxh3::new();
        for entry in self.entries.iter().filter(|entry| entry.kind != kind as u32) {
            hash.update(bytemuck::bytes_of(&Entry { offset: 0, ..*entry }));
        }
        hash.digest()
    }

    fn entry(&self, Section(kind, number): Section) -> Option<&Entry> {
        let found = self
            .entries
            .binary_search_by_key(&(kind as u32, number), Entry::section);
        Some(&self.entries[found.ok()?])
    }

    /// Returns the sections in the order of the file. Kinds that this version does not know are left out.
    pub(super) fn sections(&self) -> impl Iterator<Item = Section> {
        let mut entries: Vec<&Entry> = self.entries.iter().collect();
        entries.sort_by_key(|entry| entry.offset);
        entries.into_iter().filter_map(|entry| {
            let kind = Kind::ALL.into_iter().find(|&kind| kind as u32 == entry.kind)?;
            Some(Section(kind, entry.number))
        })
    }

    /// Returns the number of sections of a kind.
    pub(super) fn count(&self, kind: Kind) -> u32 {
        let of_kind = self.entries.iter().filter(|entry| entry.kind == kind as u32);
        of_kind.count() as u32
    }

    /// Returns the number and the bytes of all sections of each kind.
    pub(super) fn totals(&self) -> impl Iterator<Item = SectionTotal> {
        Kind::ALL.into_iter().map(|kind| {
            let of_kind = self.entries.iter().filter(move |entry| entry.kind == kind as u32);
            SectionTotal {
                kind: kind.name(),
                count: self.count(kind),
                bytes: of_kind.map(|entry| entry.length).sum(),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn written() -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let mut writer = Writer::new(&mut file).expect("started");
        for (section, bytes) in [
            (Section(Kind::Scene, 0), &b"a scene"[..]),
            (Section(Kind::Page, 0), &[]),
            (Section(Kind::Page, 1), &[7; 1000]),
        ] {
            writer.section(section, bytes).expect("written");
        }
        assert_eq!(writer.finish().expect("finished"), file.get_ref().len() as u64);
        file.into_inner()
    }

    fn sections(bytes: Vec<u8>) -> Result<Vec<Bytes>, BrokenRule> {
        let container = Container::open(Source::Memory(bytes.into()))?;
        let sections = [
            Section(Kind::Scene, 0),
            Section(Kind::Page, 0),
            Section(Kind::Page, 1),
        ];
        sections
            .into_iter()
            .map(|section| container.section(section))
            .collect()
    }

    #[test]
    fn a_damaged_byte_anywhere_is_an_error_or_lies_between_sections() {
        let whole = written();
        let read = sections(whole.clone()).expect("sections");
        assert_eq!(read, [&b"a scene"[..], &[], &[7; 1000]]);
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x10;
            match sections(damaged) {
                Ok(still) => assert_eq!(still, read, "byte {at}"),
                Err(BrokenRule::Enf(EnfError::Damaged(section))) => {
                    assert!(["header", "table of sections", "scene", "page 1"].contains(&&*section));
                }
                Err(BrokenRule::Enf(EnfError::Version(_))) => assert!((8..12).contains(&at), "byte {at}"),
                Err(other) => panic!("byte {at}: {other}"),
            }
        }
    }

    #[test]
    fn a_file_of_any_other_length_is_an_error() {
        let whole = written();
        for length in 0..whole.len() {
            assert!(sections(whole[..length].to_vec()).is_err(), "{length} bytes");
        }
        assert!(sections([&whole[..], &[0]].concat()).is_err());
    }
}
