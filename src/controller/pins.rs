//! What is wired to the controller's input pins, and switches that the moving axes close by themselves.
//!
//! "Active" is meant as the firmware means it after `$5` and `$6`: a closed limit switch, a probe in contact, a pressed button.

/// The input pins as a hand or a script holds them; true is active. Switch models ([`Switches`]) add to them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pins {
    /// Limit switches of X, Y, Z; both ends of an axis share one pin.
    pub limit: [bool; 3],
    /// The probe touches.
    pub probe: bool,
    /// The safety door is open (only builds with [`super::Quirks::door_pin`] look at it).
    pub door: bool,
    /// The feed-hold button.
    pub hold: bool,
    /// The reset button.
    pub reset: bool,
    /// The cycle-start button (on the door pin's builds too).
    pub cycle_start: bool,
}

/// Switches at fixed places, in steps of the machine *as it stood at power-up*: finding its home does not move a machine's switches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Switches {
    /// `[x-, x+, y-, y+, z-, z+]`: closed at or below the first, at or above the second of each axis; `None`: there is none.
    pub limits: [Option<i64>; 6],
    /// The probe touches at or below this many Z steps.
    pub probe_z: Option<i64>,
}
