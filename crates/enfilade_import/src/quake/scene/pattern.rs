//! Generates pattern textures over plain colors, which show the scale and orientation of a face.

/// A tileable grey image; its discriminant is its texture index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pattern {
    Plates,
    Bricks,
    Planks,
    Rough,
}

pub(super) const PATTERNS: [Pattern; 4] = [Pattern::Plates, Pattern::Bricks, Pattern::Planks, Pattern::Rough];

const SIZE: i32 = 64;

impl Pattern {
    /// Returns the name, the side length, and the texels row by row.
    pub(super) fn image(self) -> (&'static str, u32, Vec<[u8; 4]>) {
        let name = match self {
            Pattern::Plates => "plates",
            Pattern::Bricks => "bricks",
            Pattern::Planks => "planks",
            Pattern::Rough => "rough",
        };
        let texels = (0..SIZE * SIZE).map(|at| {
            let grey = self.grey(at % SIZE, at / SIZE).clamp(0.0, 255.0) as u8;
            [grey, grey, grey, 255]
        });
        (name, SIZE as u32, texels.collect())
    }

    fn grey(self, x: i32, y: i32) -> f32 {
        let grain = 10.0 * noise(x, y, 1) + 14.0 * soft_noise(x, y, 8) + 10.0 * soft_noise(x, y, 16);
        match self {
            Pattern::Plates => 226.0 + grain - seam(x, 64) - seam(y, 64),
            Pattern::Bricks => {
                let row = y / 16;
                let shifted = (x + 16 * (row % 2)) % SIZE;
                let tone = 26.0 * noise(shifted / 32, row, 2);
                224.0 + grain + tone - seam(shifted, 32) - seam(y, 16)
            }
            Pattern::Planks => {
                let tone = 24.0 * noise(x / 16, 0, 3);
                224.0 + 0.5 * grain + 16.0 * soft_noise(x * 4 % SIZE, y, 32) + tone - seam(x, 16)
            }
            Pattern::Rough => 222.0 + 1.6 * grain + 16.0 * soft_noise(x, y, 32),
        }
    }
}

/// Returns how much darker a texel is near a joint; joints repeat every `every` texels.
fn seam(at: i32, every: i32) -> f32 {
    match at % every {
        0 => 62.0,
        1 => 20.0,
        last if last == every - 1 => -12.0,
        _ => 0.0,
    }
}

/// Returns hash noise from −1 to 1.
fn noise(x: i32, y: i32, of: u32) -> f32 {
    let mut number = (x as u32).wrapping_mul(0x8da6_b343) ^ (y as u32).wrapping_mul(0xd816_3841) ^ of << 7;
    number = (number ^ number >> 15).wrapping_mul(0x2c1b_3c6d);
    number = (number ^ number >> 12).wrapping_mul(0x297a_2d39);
    ((number ^ number >> 15) & 0xffff) as f32 / 32768.0 - 1.0
}

/// Returns smooth noise, interpolated between points `apart` texels apart; tileable.
fn soft_noise(x: i32, y: i32, apart: i32) -> f32 {
    let cells = SIZE / apart;
    let [column, row] = [x / apart, y / apart];
    let [u, v] = [x % apart, y % apart].map(|at| {
        let part = at as f32 / apart as f32;
        part * part * (3.0 - 2.0 * part)
    });
    let at = |right: i32, down: i32| noise((column + right) % cells, (row + down) % cells, apart as u32);
    let upper = at(0, 0) * (1.0 - u) + at(1, 0) * u;
    let lower = at(0, 1) * (1.0 - u) + at(1, 1) * u;
    upper * (1.0 - v) + lower * v
}
