//! Explicit Runge–Kutta tableaux with a number of stages that is known at compile time, for
//! innermost loops.

/// An explicit Runge–Kutta method with `S` stages: `k_i = f(y + h Σ_{j<i} a_ij k_j)`,
/// `y⁺ = y + h Σ b_i k_i`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tableau<const S: usize> {
    pub a: [[f64; S]; S],
    pub b: [f64; S],
    pub c: [f64; S],
}

/// The method of order 6 with seven stages of Butcher 1964 (On Runge–Kutta processes of high order,
/// J. Austral. Math. Soc. 4).
pub(crate) const SIXTH: Tableau<7> = Tableau {
    a: [
        [0.0; 7],
        [1.0 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 2.0 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1.0 / 12.0, 1.0 / 3.0, -1.0 / 12.0, 0.0, 0.0, 0.0, 0.0],
        [-1.0 / 16.0, 9.0 / 8.0, -3.0 / 16.0, -3.0 / 8.0, 0.0, 0.0, 0.0],
        [0.0, 9.0 / 8.0, -3.0 / 8.0, -3.0 / 4.0, 1.0 / 2.0, 0.0, 0.0],
        [9.0 / 44.0, -9.0 / 11.0, 63.0 / 44.0, 18.0 / 11.0, 0.0, -16.0 / 11.0, 0.0],
    ],
    b: [11.0 / 120.0, 0.0, 27.0 / 40.0, 27.0 / 40.0, -4.0 / 15.0, -4.0 / 15.0, 11.0 / 120.0],
    c: [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0, 1.0 / 2.0, 1.0 / 2.0, 1.0],
};

/// The method of order 4 with four stages of Kutta 1901, for short steps.
pub(crate) const FOURTH: Tableau<4> = Tableau {
    a: [[0.0; 4], [0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    b: [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    c: [0.0, 0.5, 0.5, 1.0],
};

/// The method of order 8 with eleven stages of Cooper and Verner, *Some explicit Runge–Kutta
/// methods of high order*, 1972, with `s = √21`.
#[rustfmt::skip]
pub(crate) const EIGHTH: Tableau<11> = {
    let s = 4.582_575_694_955_84;
    let z = 0.0;
    Tableau {
        a: [
            [z; 11],
            [0.5, z, z, z, z, z, z, z, z, z, z],
            [0.25, 0.25, z, z, z, z, z, z, z, z, z],
            [1.0 / 7.0, (-7.0 - 3.0 * s) / 98.0, (21.0 + 5.0 * s) / 49.0, z, z, z, z, z, z, z, z],
            [(11.0 + s) / 84.0, z, (18.0 + 4.0 * s) / 63.0, (21.0 - s) / 252.0, z, z, z, z, z, z, z],
            [(5.0 + s) / 48.0, z, (9.0 + s) / 36.0, (-231.0 + 14.0 * s) / 360.0,
                (63.0 - 7.0 * s) / 80.0, z, z, z, z, z, z],
            [
                (10.0 - s) / 42.0, z, (-432.0 + 92.0 * s) / 315.0, (633.0 - 145.0 * s) / 90.0,
                (-504.0 + 115.0 * s) / 70.0, (63.0 - 13.0 * s) / 35.0, z, z, z, z, z,
            ],
            [1.0 / 14.0, z, z, z, (14.0 - 3.0 * s) / 126.0, (13.0 - 3.0 * s) / 63.0, 1.0 / 9.0, z, z, z, z],
            [
                1.0 / 32.0, z, z, z, (91.0 - 21.0 * s) / 576.0, 11.0 / 72.0, (-385.0 - 75.0 * s) / 1152.0,
                (63.0 + 13.0 * s) / 128.0, z, z, z,
            ],
            [
                1.0 / 14.0, z, z, z, 1.0 / 9.0, (-733.0 - 147.0 * s) / 2205.0, (515.0 + 111.0 * s) / 504.0,
                (-51.0 - 11.0 * s) / 56.0, (132.0 + 28.0 * s) / 245.0, z, z,
            ],
            [
                z, z, z, z, (-42.0 + 7.0 * s) / 18.0, (-18.0 + 28.0 * s) / 45.0, (-273.0 - 53.0 * s) / 72.0,
                (301.0 + 53.0 * s) / 72.0, (28.0 - 28.0 * s) / 45.0, (49.0 - 7.0 * s) / 18.0, z,
            ],
        ],
        b: [1.0 / 20.0, z, z, z, z, z, z, 49.0 / 180.0, 16.0 / 45.0, 49.0 / 180.0, 1.0 / 20.0],
        c: [
            0.0, 0.5, 0.5, (7.0 + s) / 14.0, (7.0 + s) / 14.0, 0.5, (7.0 - s) / 14.0, (7.0 - s) / 14.0, 0.5,
            (7.0 + s) / 14.0, 1.0,
        ],
    }
};
