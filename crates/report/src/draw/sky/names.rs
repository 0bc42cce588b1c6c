//! Placement of names on a map. Names do not overlap, and do not cover tracks if enough space is
//! left.

use super::super::clear::crosses;

/// Width of a wide character of a sans-serif font, as a fraction of the font size.
const WIDE: f64 = 0.6;

/// The distance between a name and its object \[px\].
const BESIDE: f64 = 7.0;

/// Number of rows above and below an object that are searched for a free place.
const ROWS: i32 = 12;

/// Rectangles of the map that are occupied, each given by left, top, right and bottom \[px\].
pub(super) struct Names {
    taken: Vec<[f64; 4]>,
    /// The tracks that names should not cover.
    tracks: Vec<Vec<(f64, f64)>>,
    /// The rectangle in which all names must lie.
    within: [f64; 4],
}

impl Names {
    /// Creates an empty list of occupied rectangles. All names will be placed in the rectangle
    /// `within`, and not on `tracks` if possible.
    pub fn within(within: [f64; 4], tracks: Vec<Vec<(f64, f64)>>) -> Self {
        Self { taken: Vec::new(), tracks, within }
    }

    /// Reserves a square around a point, which names will not cover. Half of its side is `by`
    /// \[px\].
    pub fn keep_clear(&mut self, (x, y): (f64, f64), by: f64) {
        self.taken.push([x - by, y - by, x + by, y + by]);
    }

    /// Returns the position for a name with the font size `size` \[px\], and reserves it. The name
    /// is to the right or to the left of its object, in the nearest free row.
    pub fn beside(&mut self, (x, y): (f64, f64), name: &str, size: f64) -> (f64, f64) {
        let width = Self::width(name, size);
        // The rows are tried from the nearest to the farthest, alternately below and above the
        // object.
        let rows = (0..ROWS).flat_map(|row| [f64::from(row), f64::from(-row - 1)]);
        let at = |row: f64, left: bool| {
            let x = if left { x - BESIDE - width } else { x + BESIDE };
            (x, y + (row + 1.0) * (size + 2.0))
        };
        let places = rows.flat_map(|row| [at(row, false), at(row, true)]);
        let free: Vec<_> = places.filter(|place| self.is_free(*place, name, size)).collect();
        let off_tracks = free.iter().find(|place| self.is_off_tracks(**place, name, size));
        // If all places are occupied, the name is placed next to the object and overlaps others.
        let place = off_tracks.or(free.first()).copied().unwrap_or_else(|| at(0.0, false));
        self.take(place, name, size);
        place
    }

    /// Reserves the place of a text if it is free and covers no track. Returns true if it was
    /// reserved.
    pub fn if_free(&mut self, place: (f64, f64), name: &str, size: f64) -> bool {
        let free = self.is_free(place, name, size) && self.is_off_tracks(place, name, size);
        if free {
            self.take(place, name, size);
        }
        free
    }

    fn width(name: &str, size: f64) -> f64 {
        WIDE * size * name.chars().count() as f64
    }

    fn of((x, y): (f64, f64), name: &str, size: f64) -> [f64; 4] {
        [x, y - size, x + Self::width(name, size), y + 0.25 * size]
    }

    fn is_free(&self, place: (f64, f64), name: &str, size: f64) -> bool {
        let [left, top, right, bottom] = Self::of(place, name, size);
        let [first, highest, last, lowest] = self.within;
        let inside = left >= first && top >= highest && right <= last && bottom <= lowest;
        inside
            && self
                .taken
                .iter()
                .all(|other| left >= other[2] || right <= other[0] || top >= other[3] || bottom <= other[1])
    }

    fn is_off_tracks(&self, place: (f64, f64), name: &str, size: f64) -> bool {
        let frame = Self::of(place, name, size);
        self.tracks.iter().all(|track| !crosses(track, frame))
    }

    fn take(&mut self, place: (f64, f64), name: &str, size: f64) {
        self.taken.push(Self::of(place, name, size));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_covers_another_where_all_stand_in_one_place() {
        let mut names = Names::within([0.0, 0.0, 400.0, 400.0], Vec::new());
        let all = ["Earth", "ground 48.1, 11.6", "star tracker off the Earth", "Moon", "Earth"];
        for name in all {
            names.beside((200.0, 200.0), name, 11.0);
        }
        for (index, [left, top, right, bottom]) in names.taken.iter().enumerate() {
            for other in &names.taken[..index] {
                assert!(left >= &other[2] || right <= &other[0] || top >= &other[3] || bottom <= &other[1]);
            }
        }
        assert_eq!(names.taken.len(), all.len());
        assert!(!names.if_free((207.0, 213.0), "30°", 10.0) && names.if_free((20.0, 20.0), "30°", 10.0));
    }

    #[test]
    fn names_stay_off_tracks_where_there_is_room() {
        // The first track passes through the preferred place of a name. The second one leaves no
        // free place.
        let track = vec![(0.0, 208.0), (400.0, 208.0)];
        let mut names = Names::within([0.0, 0.0, 400.0, 400.0], vec![track.clone()]);
        names.beside((200.0, 200.0), "Sun", 11.0);
        assert!(!crosses(&track, names.taken[0]), "{:?}", names.taken);
        assert!(!names.if_free((20.0, 210.0), "30°", 10.0));
        let hatch = (0..800).map(|k| (if k % 2 == 0 { 0.0 } else { 400.0 }, f64::from(k / 2))).collect();
        let mut names = Names::within([0.0, 0.0, 400.0, 400.0], vec![hatch]);
        assert_eq!(names.beside((200.0, 200.0), "Sun", 11.0), (207.0, 213.0));
    }

    #[test]
    fn names_stay_within_the_picture_and_off_the_ends_of_tracks() {
        let mut names = Names::within([0.0, 0.0, 400.0, 400.0], Vec::new());
        names.keep_clear((380.0, 200.0), 6.0);
        for at in [(395.0, 200.0), (5.0, 398.0), (380.0, 200.0)] {
            let name = "star tracker off the Earth";
            let (x, y) = names.beside(at, name, 11.0);
            assert!(x >= 0.0 && x + Names::width(name, 11.0) <= 400.0 && (11.0..=400.0).contains(&y));
            assert!(x + Names::width(name, 11.0) <= 374.0 || !(194.0..217.0).contains(&y), "{x} {y}");
        }
    }
}
