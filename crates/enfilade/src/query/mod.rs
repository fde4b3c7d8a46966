//! Scene queries: ray casts, movement through portals, proximity, light reach and camera placement.

mod beam;
mod between;
mod cast;
mod items;
#[cfg(feature = "terrain")]
mod large_terrain;
mod light;
mod location;
mod near;
mod nearest;
mod ray;
mod sees;
mod survey;

pub use beam::LightReach;
pub use between::BoxVisibility;
pub use location::{BodyInSector, Location, MoveResult};
pub use near::{NearItem, NearItems};
pub use nearest::NearestItem;
pub use ray::{RayCast, RayEnd};
pub use sees::SightLine;
pub use survey::{Survey, SurveyOptions, SurveyView, survey, survey_hard, survey_in, survey_with};
