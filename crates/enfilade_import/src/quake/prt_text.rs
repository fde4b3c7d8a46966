//! Writes the text of a portal file, in the layout of the map compilers.

use super::{PortalFile, PrtKind};
use std::fmt::Write;

impl PortalFile {
    /// Returns the text of a file of this kind. [`PortalFile::parse`] reads the same portals back, bit-exact. A Quake 3
    /// file has no hint flags and no solid faces.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        // Writing to a `String` cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> std::fmt::Result {
        let [clusters, portals] = [self.cells.count() as usize, self.cells.portals().len()];
        let leafs = self.cluster_of_leaf.as_deref().unwrap_or_default();
        match self.kind {
            PrtKind::Prt1 => writeln!(text, "PRT1\n{clusters}\n{portals}")?,
            PrtKind::Prt2 => writeln!(text, "PRT2\n{}\n{clusters}\n{portals}", leafs.len())?,
            PrtKind::Quake3 => writeln!(text, "PRT1\n{clusters}\n{portals}\n0")?,
        }
        for portal in self.cells.portals() {
            let [from, to] = portal.cells;
            write!(text, "{} {from} {to} ", portal.corners.len())?;
            if self.kind == PrtKind::Quake3 {
                text.push_str("0 ");
            }
            for [x, y, z] in &portal.corners {
                write!(text, "({x} {y} {z} ) ")?;
            }
            text.push('\n');
        }
        if self.kind == PrtKind::Prt2 {
            let mut of_cluster = vec![String::new(); clusters];
            for (leaf, &cluster) in leafs.iter().enumerate() {
                if let Some(line) = of_cluster.get_mut(cluster as usize) {
                    write!(line, "{leaf} ")?;
                }
            }
            of_cluster
                .iter()
                .try_for_each(|leafs| writeln!(text, "{leafs}-1"))?;
        }
        Ok(())
    }
}
