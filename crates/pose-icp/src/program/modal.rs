//! What earlier blocks left in force.

use nalgebra::Vector3;

use super::block::Piece;
use super::error::Refused;

/// Kind of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    Rapid,
    Linear,
    /// G2.
    Clockwise,
    /// G3.
    Counterclockwise,
    /// G38.2 to G38.5: straight, and the probe ends it.
    Probing,
}

impl Motion {
    pub(super) fn is_arc(self) -> bool {
        matches!(self, Self::Clockwise | Self::Counterclockwise)
    }
}

/// State of the controller, in the program's own unit of length.
#[derive(Clone, Debug)]
pub(super) struct Modal {
    pub(super) motion: Option<Motion>,
    pub(super) is_incremental: bool,
    /// Whether centres of arcs are absolute (G90.1).
    pub(super) has_absolute_centers: bool,
    /// Axis across the plane of arcs: 2 for G17, 1 for G18, 0 for G19.
    pub(super) across: usize,
    pub(super) mm_per_unit: f64,
    /// Planned position; unknown axes are `None`.
    pub(super) position: [Option<f64>; 3],
}

impl Default for Modal {
    fn default() -> Self {
        Self {
            motion: None,
            is_incremental: false,
            has_absolute_centers: false,
            across: 2,
            mm_per_unit: 1.0,
            position: [None; 3],
        }
    }
}

const MM_PER_INCH: f64 = 25.4;

/// Words of a block that a correction rewrites.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Coordinates {
    pub(super) axes: [Option<f64>; 3],
    /// I, J, K.
    pub(super) center: [Option<f64>; 3],
    pub(super) radius: Option<f64>,
}

impl Coordinates {
    pub(super) fn has_axes(&self) -> bool {
        self.axes.iter().any(Option::is_some)
    }

    fn has_center(&self) -> bool {
        self.center.iter().any(Option::is_some) || self.radius.is_some()
    }

    /// Whether the block moves: an arc may be a full circle without an end.
    pub(super) fn moves(&self, motion: Option<Motion>) -> bool {
        self.has_axes() || (motion.is_some_and(Motion::is_arc) && self.has_center())
    }
}

impl Modal {
    /// Takes the block's codes into force and returns its coordinates.
    pub(super) fn take(&mut self, pieces: &[Piece<'_>]) -> Result<Coordinates, Refused> {
        let mut coordinates = Coordinates::default();
        for piece in pieces {
            let Piece::Word { letter, value, .. } = *piece else { continue };
            match letter {
                'G' => self.code(value)?,
                'X' => coordinates.axes[0] = Some(value),
                'Y' => coordinates.axes[1] = Some(value),
                'Z' => coordinates.axes[2] = Some(value),
                'I' => coordinates.center[0] = Some(value),
                'J' => coordinates.center[1] = Some(value),
                'K' => coordinates.center[2] = Some(value),
                'R' => coordinates.radius = Some(value),
                'A' | 'B' | 'C' | 'U' | 'V' | 'W' => return Err(Refused::Axis { axis: letter }),
                _ => {}
            }
        }
        if coordinates.has_axes() && self.motion.is_none() {
            return Err(Refused::NoMotion);
        }
        Ok(coordinates)
    }

    fn code(&mut self, code: f64) -> Result<(), Refused> {
        // Codes have one decimal at most: compared in tenths.
        #[expect(clippy::cast_possible_truncation, reason = "codes are below 1000")]
        let tenths = (10.0 * code.clamp(-1.0, 1000.0)).round() as i32;
        match tenths {
            0 => self.motion = Some(Motion::Rapid),
            10 => self.motion = Some(Motion::Linear),
            20 => self.motion = Some(Motion::Clockwise),
            30 => self.motion = Some(Motion::Counterclockwise),
            382..=385 => self.motion = Some(Motion::Probing),
            170 => self.across = 2,
            180 => self.across = 1,
            190 => self.across = 0,
            200 => self.mm_per_unit = MM_PER_INCH,
            210 => self.mm_per_unit = 1.0,
            900 => self.is_incremental = false,
            910 => self.is_incremental = true,
            901 => self.has_absolute_centers = true,
            911 => self.has_absolute_centers = false,
            // Dwell, tool compensation off, tool length, work offsets, path control, feed and
            // speed modes: none of them has a coordinate of the part.
            40
            | 400
            | 430
            | 490
            | 540..=590
            | 610
            | 611
            | 640
            | 800
            | 930
            | 940
            | 950
            | 960
            | 970 => {}
            _ => return Err(Refused::Code { code }),
        }
        Ok(())
    }

    /// Where the block's words lead.
    pub(super) fn target(&self, coordinates: &Coordinates) -> [Option<f64>; 3] {
        std::array::from_fn(|k| match (coordinates.axes[k], self.position[k]) {
            (Some(step), Some(from)) if self.is_incremental => Some(from + step),
            (Some(_), None) if self.is_incremental => None,
            (Some(to), _) => Some(to),
            (None, from) => from,
        })
    }
}

/// The position, if all of it is known.
pub(super) fn known(position: [Option<f64>; 3]) -> Option<Vector3<f64>> {
    Some(Vector3::new(position[0]?, position[1]?, position[2]?))
}
