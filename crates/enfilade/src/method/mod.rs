//! Visibility methods: each combines an order with a cover. Only this module depends on both.

mod combined;
mod culled;
mod editable;
mod enlarged;
mod found;
mod gathered;
mod in_cells;
#[cfg(feature = "terrain")]
mod large_terrain;
mod ordered;
mod paired;
mod shares;
mod strips;
mod table;
mod visit;

pub use culled::Culled;
pub use editable::EditStats;
pub(crate) use editable::EditableSector;
pub use ordered::Ordered;
pub use paired::Paired;
pub use table::*;

use crate::contract::Contract;
use crate::geometry::Geometry;
use crate::sector::{Requirement, Sector};
use crate::unsuited::Unsuited;
use crate::view::View;
use crate::view::canvas::CoverShape;
use std::fmt;
use std::sync::Arc;
use thiserror::Error;

/// A method does not fit a geometry.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("method {method} {reason}{}", self.advice())]
pub struct UnsuitedMethod {
    /// The requested method.
    pub method: Method,
    /// Why it does not fit.
    pub reason: Unsuited,
}

impl UnsuitedMethod {
    /// Other reasons name what to do themselves.
    fn advice(&self) -> &'static str {
        match self.reason {
            #[cfg(feature = "exact")]
            Unsuited::TooLarge { .. } if self.method != Method::ZBuffer => "; z-buffer needs less",
            _ => "",
        }
    }
}

impl Method {
    /// All methods. Not every geometry meets the [requirement](Method::requires) of each; test with [`Method::suits`]. A
    /// method that accepted any geometry instead (geometry without baked cells as one large cell, for example) would
    /// only look as if it worked.
    pub const ALL: [Method; TABLE.len()] = {
        let mut all = [Method::Masked; TABLE.len()];
        let mut number = 0;
        while number < all.len() {
            all[number] = TABLE[number].method;
            // `row` looks a method up by its number.
            assert!(all[number] as usize == number);
            number += 1;
        }
        all
    };

    /// Default memory limit per sector for what its method builds, in bytes: 1 GB.
    pub const DEFAULT_LIMIT: u64 = 1_000_000_000;

    /// Returns the name used on the command line and in files, such as `hierarchical-z`.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Returns the method with the given name; `None` if there is none.
    pub fn by_name(name: &str) -> Option<Method> {
        Method::ALL.into_iter().find(|method| method.name() == name)
    }

    pub(crate) fn unsuited(self, reason: Unsuited) -> UnsuitedMethod {
        UnsuitedMethod { method: self, reason }
    }

    fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }

    /// Returns the publication that describes the method.
    pub fn source(self) -> &'static str {
        self.row().source
    }

    /// Returns the name of the [order](crate::order), as in `OctreeOrder`.
    pub fn order(self) -> &'static str {
        self.row().order
    }

    /// Returns the name of the [cover](crate::cover), as in `DepthPyramid`; empty if the method has none.
    pub fn cover(self) -> &'static str {
        self.row().cover
    }

    /// Returns the guarantee on the visible set, with a cover of the screen's resolution
    /// ([`Method::takes_cover_size`]).
    pub fn contract(self) -> Contract {
        self.row().contract
    }

    /// Returns `true` if the cover can have another resolution than the screen
    /// ([`ViewerOptions::cover_size`](crate::ViewerOptions::cover_size)). The method is conservative then.
    pub fn takes_cover_size(self) -> bool {
        self.row().takes_cover_size
    }

    /// Returns what the geometry must have for this method; `None` if it takes any geometry.
    pub fn requires(self) -> Option<Requirement> {
        self.row().requires
    }

    /// Returns the default number of occluders per passage ([`ViewerOptions::occluders`](crate::ViewerOptions::occluders));
    /// `None` if the method selects none.
    pub fn occluders(self) -> Option<u32> {
        self.row().occluders
    }

    /// Returns `true` if building sorts all faces into a BSP tree. That splits some, and takes long for many faces.
    pub(crate) fn splits_faces(self) -> bool {
        self.row().splits_faces
    }

    /// Returns `true` if a geometry meets the [requirement](Method::requires) of the method. For [`Method::Cell`] and
    /// [`Method::FloatingHorizon`] this costs as much as building it.
    pub fn suits(self, geometry: &Geometry) -> bool {
        (self.row().suits)(geometry)
    }

    /// Builds the method for a geometry.
    ///
    /// # Errors
    /// Returns [`Unsuited::TooLarge`] if more than `limit_bytes` are needed, another reason if the geometry does not meet
    /// the [requirement](Method::requires).
    pub fn build(self, geometry: Arc<Geometry>, limit_bytes: u64) -> Result<Arc<dyn Sector>, UnsuitedMethod> {
        Ok(self.build_editable(geometry, limit_bytes)?)
    }

    pub(crate) fn build_editable(
        self,
        geometry: Arc<Geometry>,
        limit_bytes: u64,
    ) -> Result<Arc<dyn EditableSector>, UnsuitedMethod> {
        let built = (self.row().build)(geometry, limit_bytes);
        built.map_err(|reason| self.unsuited(reason))
    }

    /// Returns the memory of its screen buffers, in bytes, for a viewport of `size` [width, height] in pixels;
    /// `cover_size` as in [`ViewerOptions::cover_size`](crate::ViewerOptions::cover_size).
    pub fn screen_bytes(self, size: [u32; 2], cover_size: Option<[u32; 2]>) -> u64 {
        (self.row().screen_bytes)(size, cover_size)
    }

    /// Returns how the cover divides the screen, for visualization; `None` if there is nothing to show.
    pub fn cover_shape(self) -> Option<CoverShape> {
        self.row().cover_shape
    }

    /// Checks that the screen buffers for a view fit in `limit_bytes`.
    ///
    /// # Errors
    /// Returns [`Unsuited::TooLarge`] if they do not.
    pub fn check_screen(
        self,
        view: &View,
        cover_size: Option<[u32; 2]>,
        limit_bytes: u64,
    ) -> Result<(), UnsuitedMethod> {
        let needs_bytes = self.screen_bytes(view.size(), cover_size);
        if needs_bytes > limit_bytes {
            return Err(self.unsuited(Unsuited::TooLarge {
                needs_bytes,
                limit: limit_bytes,
            }));
        }
        Ok(())
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}
