//! Colours: linear light for shading, a palette for features, a perceptual ramp for fields.

/// Red, green, blue as on the screen, 0 to 255.
pub type Rgb = [u8; 3];

/// Ground of every picture.
pub const PAPER: Rgb = [247, 248, 250];
/// Words and frames.
pub const INK: Rgb = [34, 40, 49];
/// Lesser words.
pub const FADED: Rgb = [104, 114, 128];
/// Maxima.
pub const RED: Rgb = [214, 39, 40];
/// Minima.
pub const BLUE: Rgb = [28, 98, 200];
/// Saddles.
pub const YELLOW: Rgb = [245, 190, 10];
/// Unlabelled ground.
pub const STONE: Rgb = [196, 200, 206];
/// Above the limit of a heat map.
pub const LOUD: Rgb = [226, 26, 28];
/// Far above it.
pub const LOUDEST: Rgb = [120, 0, 12];
/// Cut into the part.
pub const GOUGE: Rgb = [214, 0, 214];

/// Feature colours: told apart by people who see all colours and by most who do not; neighbours in the list differ most.
const FEATURES: [Rgb; 12] = [
    [78, 145, 211],
    [240, 148, 62],
    [90, 175, 107],
    [176, 122, 201],
    [226, 104, 104],
    [72, 184, 184],
    [222, 185, 66],
    [229, 134, 184],
    [138, 152, 82],
    [120, 125, 214],
    [170, 126, 96],
    [126, 196, 232],
];

/// Colour of a feature by its label, from 1; label 0 (none) is stone. After twelve they come again.
pub fn feature(label: u16) -> Rgb {
    match usize::from(label).checked_sub(1) {
        None => STONE,
        Some(k) => FEATURES[k % FEATURES.len()],
    }
}

/// From dark blue over green to pale yellow in steps that look even; `t` from 0 to 1.
pub fn ramp(t: f64) -> Rgb {
    const STOPS: [Rgb; 7] = [
        [38, 40, 92],
        [42, 82, 140],
        [37, 122, 146],
        [42, 159, 137],
        [104, 193, 111],
        [178, 219, 99],
        [250, 238, 150],
    ];
    let s = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) } * (STOPS.len() - 1) as f64;
    let k = (s as usize).min(STOPS.len() - 2);
    mix(STOPS[k], STOPS[k + 1], s - k as f64)
}

/// Between two screen colours.
pub fn mix(a: Rgb, b: Rgb, t: f64) -> Rgb {
    let t = t.clamp(0.0, 1.0);
    [0, 1, 2].map(|k| (f64::from(a[k]) + (f64::from(b[k]) - f64::from(a[k])) * t).round() as u8)
}

/// Screen colour to linear light, 0 to 1 (gamma 2.2).
pub fn linear(c: Rgb) -> [f32; 3] {
    c.map(|v| (f32::from(v) / 255.0).powf(2.2))
}

/// Linear light to screen colour, overexposure rolled off.
pub fn screen(c: [f32; 3]) -> Rgb {
    c.map(|v| {
        let v = if v > 0.8 {
            0.8 + 0.2 * (1.0 - (-(v - 0.8) * 5.0).exp())
        } else {
            v.max(0.0)
        };
        (v.powf(1.0 / 2.2) * 255.0).round().clamp(0.0, 255.0) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_gets_lighter_all_the_way() {
        let light = |c: Rgb| 0.2126 * linear(c)[0] + 0.7152 * linear(c)[1] + 0.0722 * linear(c)[2];
        for k in 0..100 {
            let (a, b) = (ramp(f64::from(k) / 100.0), ramp(f64::from(k + 1) / 100.0));
            assert!(light(b) >= light(a), "{k}");
        }
        assert_eq!(ramp(f64::NAN), ramp(0.0));
    }

    #[test]
    fn light_goes_there_and_back() {
        for v in 0..=200 {
            assert!(screen(linear([v; 3]))[0].abs_diff(v) <= 1);
        }
        assert_eq!(feature(0), STONE);
        assert_eq!(feature(13), feature(1));
    }
}
