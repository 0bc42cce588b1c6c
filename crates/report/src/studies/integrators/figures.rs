//! Figures of a comparison of integrators, drawn as SVG.
//!
//! | figure | in the survey |
//! |---|---|
//! | `trajectories` | 2: the orbit with snapshots of the bodies |
//! | `energy_over_time` | 3 (a): computed total energy |
//! | `energy_over_step` | 3 (b): mean energy error |
//! | `orthogonality_over_step` | 3 (c): mean orthogonality error |
//! | `time_over_step` | 3 (d): CPU time |
//! | `energy_error_over_time`, `orthogonality_over_time`, `momentum_over_step`, `evaluations_precision`, `work_precision` | – |
//!
//! Two observations of the survey cannot be reproduced with any initial data. The implicit midpoint
//! rule conserves `RᵀR = I`, a quadratic invariant, to the tolerance of its iteration. Its energy
//! error is near the error of the variational method, not near the error of the explicit rule.

use super::{History, IntegratorRun, Path, Study, WorkPrecision};
use crate::draw::{Axis, Chart, Curve, Item, Scale, Scene, Shape};
use crate::studies::clock::THREAD_TIME;
use slewkit::mechanics::environment::Pose;
use slewkit::numerics::figures::short;
use slewkit::propagate::integrator::Kind;
use slewkit::{Matrix3, Vector3};

/// A figure of the comparison, drawn as SVG.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of the figure and of its file, without the file name extension.
    pub name: &'static str,
    /// The text of an SVG file.
    pub svg: String,
}

/// Outline of a body, which consists of rods and balls in body axes \[m\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Name of the body in the legend.
    pub name: String,
    /// Ends of the rods, which are straight lines \[m\].
    pub rods: Vec<[Vector3; 2]>,
    /// Centers and radii of the balls \[m\].
    pub balls: Vec<(Vector3, f64)>,
}

impl Outline {
    /// Returns the outline of a dumbbell: two balls joined by a rod along the first body axis.
    pub fn dumbbell(name: impl Into<String>, dumbbell: &slewkit::mechanics::full_body::Dumbbell) -> Self {
        let along = |x: f64| Vector3::new(x, 0.0, 0.0);
        let (half, radius) = (0.5 * dumbbell.length, dumbbell.sphere_radius);
        let balls = [half, -half].map(|x| (along(x), radius)).to_vec();
        // The rod ends at the surfaces of the balls. Overlapping balls hide it.
        Self { name: name.into(), rods: vec![[along(half - radius), along(radius - half)]], balls }
    }

    /// Returns the outline of a polyhedron, which consists of its edges.
    pub fn polyhedron(name: impl Into<String>, solid: &slewkit::mechanics::full_body::Polyhedron) -> Self {
        let corner = |index: u32| solid.vertices()[index as usize];
        let edges = solid.faces().iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        // Each edge borders two faces, once in each direction.
        let rods = edges.filter(|(a, b)| a < b).map(|(a, b)| [corner(a), corner(b)]).collect();
        Self { name: name.into(), rods, balls: Vec::new() }
    }

    /// Returns the outline of a point cloud, which consists of at most a few hundred of its points.
    pub fn points(name: impl Into<String>, cloud: &slewkit::mechanics::full_body::PointCloud) -> Self {
        let points = cloud.points();
        let shown = points.iter().step_by(points.len().div_ceil(300).max(1));
        let balls = shown.map(|point| (point.position, 0.0)).collect();
        Self { name: name.into(), rods: Vec::new(), balls }
    }

    /// Returns the outline of a body that is drawn as a single point.
    pub fn point(name: impl Into<String>) -> Self {
        Self { name: name.into(), rods: Vec::new(), balls: vec![(Vector3::zeros(), 0.0)] }
    }
}

/// Returns the name of a method in the legends, with its name in the survey if it has one.
fn label(kind: Kind) -> String {
    let survey = match kind {
        Kind::LieVerlet => "\nLGVI in the survey",
        Kind::CrouchGrossman2 => "\nLGM in the survey",
        Kind::ExplicitMidpoint => "\nRK in the survey",
        Kind::ImplicitMidpoint => "\nSRK in the survey",
        _ => "",
    };
    format!("{}{survey}", kind.name())
}

/// The names of the figures, in the order in which they are drawn.
pub const FIGURES: [&str; 10] = [
    "trajectories",
    "energy_over_time",
    "energy_error_over_time",
    "orthogonality_over_time",
    "energy_over_step",
    "orthogonality_over_step",
    "momentum_over_step",
    "time_over_step",
    "evaluations_precision",
    "work_precision",
];

/// Returns all figures, in the order of [`FIGURES`]. `outlines` has the outlines of the first
/// bodies; all other bodies are drawn as points.
pub fn figures(title: &str, study: &Study, found: &WorkPrecision, outlines: &[Outline]) -> Vec<Figure> {
    let trajectories = Drawn { title, study, found }.trajectories(outlines);
    let charts = charts(title, study, found).into_iter().map(|(name, chart)| (name, chart.svg()));
    let all = std::iter::once((FIGURES[0], trajectories)).chain(charts);
    all.map(|(name, svg)| Figure { name, svg }).collect()
}

/// Returns all figures except the trajectories, with their names. Figures over time exist only if
/// `found` has histories.
pub fn charts(title: &str, study: &Study, found: &WorkPrecision) -> Vec<(&'static str, Chart)> {
    let drawn = Drawn { title, study, found };
    let relative = "|E − E₀| / (T₀ + |U₀|)";
    let mean = |run: &IntegratorRun| Some(run.errors?.energy_error_mean);
    let orthogonality = |run: &IntegratorRun| Some(run.errors?.orthogonality_error_mean);
    let momentum = |run: &IntegratorRun| Some(run.errors?.angular_momentum_error_max);
    let least = format!("{THREAD_TIME}, least of several runs, s");
    let charts = [
        drawn.energy_over_time(),
        drawn.over_time("Energy error", relative, |moment| moment.energy_error),
        drawn.over_time("Orthogonality error", "‖I − RᵀR‖", |moment| moment.orthogonality),
        drawn.over_step("Mean energy error", &format!("mean {relative}"), mean),
        drawn.over_step("Mean orthogonality error", "mean ‖I − RᵀR‖", orthogonality),
        drawn.over_step("Largest error of the angular momentum", "max |L − L₀| / Σ|Lᵢ|", momentum),
        drawn.over_step(THREAD_TIME, &least, |run| run.errors.map(|_| run.time_s)),
        drawn.work("Evaluations and precision", "evaluations of the potential", |run| {
            run.force_evaluations as f64
        }),
        drawn.work("Work and precision", &least, |run| run.time_s),
    ];
    let without_histories = if found.histories.is_empty() { 3 } else { 0 };
    FIGURES.into_iter().skip(1).zip(charts).skip(without_histories).collect()
}

struct Drawn<'a> {
    title: &'a str,
    study: &'a Study,
    found: &'a WorkPrecision,
}

impl Drawn<'_> {
    fn horizon(&self) -> f64 {
        self.study.horizons.last().copied().unwrap_or(0.0)
    }

    fn curve(&self, kind: Kind, shape: Shape) -> Curve {
        let style = self.study.kinds.iter().position(|other| *other == kind).unwrap_or(0);
        Curve { name: label(kind), style, shape }
    }

    fn over_time(&self, title: &str, unit: &str, value: impl Fn(&super::Moment) -> f64) -> Chart {
        let of = |history: &History| {
            let points = history.moments.iter().map(|moment| (moment.time, value(moment))).collect();
            self.curve(history.kind, Shape::Line(points))
        };
        self.chart_over_time(title, Axis::logarithmic(unit), of)
    }

    /// Returns the chart of the total energy over time, with a band for each method.
    fn energy_over_time(&self) -> Chart {
        let of = |history: &History| {
            let band = history.moments.iter().map(|moment| (moment.time, moment.energy.0, moment.energy.1));
            self.curve(history.kind, Shape::Band(band.collect()))
        };
        self.chart_over_time("Total energy", Axis::linear("(E − E₀) / (T₀ + |U₀|)"), of)
    }

    fn chart_over_time(&self, title: &str, y: Axis, curve: impl Fn(&History) -> Curve) -> Chart {
        let limits = Some((0.0, self.horizon()));
        Chart {
            title: title.into(),
            subtitle: format!("{}, step {} s", self.title, short(self.study.shown_step)),
            x: Axis { limits, ..Axis::linear("time, s") },
            y,
            curves: self.found.histories.iter().map(curve).collect(),
            levels: Vec::new(),
            spans: Vec::new(),
        }
    }

    /// Returns the runs of a method over the longest horizon, in the order of decreasing steps.
    fn runs(&self, kind: Kind) -> impl Iterator<Item = &IntegratorRun> {
        let horizon = self.horizon().to_bits();
        let runs = self.found.runs.iter();
        runs.filter(move |run| run.method == kind.name() && run.horizon_s.to_bits() == horizon)
    }

    fn over_step(&self, title: &str, unit: &str, value: impl Fn(&IntegratorRun) -> Option<f64>) -> Chart {
        let curve = |kind: &Kind| {
            let points = self.runs(*kind).filter_map(|run| Some((run.step_s, value(run)?))).collect();
            self.curve(*kind, Shape::Marked(points))
        };
        Chart {
            title: title.into(),
            subtitle: format!("{}, over {} s", self.title, short(self.horizon())),
            x: Axis::logarithmic("step, s"),
            y: Axis { scale: Scale::Logarithmic, label: unit.into(), limits: None },
            curves: self.study.kinds.iter().map(curve).collect(),
            levels: Vec::new(),
            spans: Vec::new(),
        }
    }

    fn work(&self, title: &str, unit: &str, work: impl Fn(&IntegratorRun) -> f64) -> Chart {
        let curve = |kind: &Kind| {
            let point = |run: &IntegratorRun| Some((work(run), run.errors?.energy_error_mean));
            self.curve(*kind, Shape::Marked(self.runs(*kind).filter_map(point).collect()))
        };
        Chart {
            title: title.into(),
            subtitle: format!("{}, over {} s", self.title, short(self.horizon())),
            x: Axis::logarithmic(unit),
            y: Axis::logarithmic("mean |E − E₀| / (T₀ + |U₀|)"),
            curves: self.study.kinds.iter().map(curve).collect(),
            levels: Vec::new(),
            spans: Vec::new(),
        }
    }

    fn trajectories(&self, outlines: &[Outline]) -> String {
        let path = &self.found.path;
        let moves = path.moves.iter().any(|moves| *moves);
        let (items, names, shown) = match path.poses.first().filter(|poses| !poses.is_empty()) {
            None => Default::default(),
            Some(_) if moves => orbits(path, outlines),
            Some(_) => tips(path),
        };
        let step = self.study.steps.last().copied().unwrap_or(0.0);
        let span = short((shown as u64 * path.stride) as f64 * step);
        let (title, unit) = if moves {
            ("Trajectories, the first revolution solid", "m")
        } else {
            ("Tips of the body axes in the reference frame", "unit sphere")
        };
        let method = self.study.kinds.first().map_or("no method", |kind| kind.name());
        let subtitle =
            format!("{}, over {span} s, {method} at its shortest step, {} s", self.title, short(step));
        Scene { title: title.into(), subtitle, unit: unit.into(), names, items }.svg()
    }
}

/// Number of snapshots of the bodies in the first revolution.
const SNAPSHOTS: usize = 8;
/// Number of revolutions that are drawn.
const REVOLUTIONS: usize = 3;

/// Largest number of points of a line; more points would not be visible.
const POINTS: usize = 1200;

fn thinned<T: Clone>(points: &[T]) -> Vec<T> {
    let stride = points.len().div_ceil(POINTS).max(1);
    let mut thin: Vec<T> = points.iter().step_by(stride).cloned().collect();
    if !(points.len() - 1).is_multiple_of(stride) {
        thin.extend(points.last().cloned());
    }
    thin
}

/// Returns the paths of the mass centers with snapshots of the bodies, the names of the bodies, and
/// the index of the last drawn pose.
fn orbits(path: &Path, outlines: &[Outline]) -> (Vec<Item>, Vec<String>, usize) {
    let first = revolution(path);
    let last = (REVOLUTIONS * first).min(path.poses[0].len() - 1);
    let (mut items, mut names) = (Vec::new(), Vec::new());
    for (style, poses) in path.poses.iter().enumerate() {
        let outline = outlines.get(style).cloned();
        let outline = outline.unwrap_or_else(|| Outline::point(format!("body {}", style + 1)));
        let points: Vec<Vector3> = poses[..=last].iter().map(|pose| pose.position).collect();
        items.push(Item::Path { points: thinned(&points[first..]), style, faint: true });
        items.push(Item::Path { points: thinned(&points[..=first]), style, faint: false });
        for snapshot in 0..SNAPSHOTS {
            let Pose { position, attitude } = poses[first * snapshot / SNAPSHOTS];
            let place = |point: &Vector3| position + attitude * point;
            let rod = |ends: &[Vector3; 2]| Item::Rod { ends: [place(&ends[0]), place(&ends[1])], style };
            let ball = |(center, radius): &(Vector3, f64)| Item::Ball {
                center: place(center),
                radius: *radius,
                style,
            };
            items.extend(outline.rods.iter().map(rod));
            items.extend(outline.balls.iter().map(ball));
        }
        names.push(outline.name);
    }
    (items, names, last)
}

/// Returns the index of the pose at the end of the first body's first revolution about the second
/// body or the origin; the last index if the revolution is not complete.
fn revolution(path: &Path) -> usize {
    let count = path.poses[0].len();
    let arm = |index: usize| {
        let about = path.poses.get(1).map_or_else(Vector3::zeros, |poses| poses[index].position);
        path.poses[0][index].position - about
    };
    let mut turned = 0.0;
    for index in 1..count {
        turned += arm(index - 1).angle(&arm(index));
        if turned >= 2.0 * std::f64::consts::PI {
            return index;
        }
    }
    count - 1
}

/// Returns the paths of the tips of the first body's axes, their names, and the index of the last
/// drawn pose.
fn tips(path: &Path) -> (Vec<Item>, Vec<String>, usize) {
    let poses = &path.poses[0];
    let tip = |axis: usize| -> Vec<Vector3> {
        poses.iter().map(|pose| Matrix3::column(&pose.attitude, axis).into_owned()).collect()
    };
    let mut items = Vec::new();
    for style in 0..3 {
        let points = tip(style);
        let end = points[points.len() - 1];
        items.push(Item::Path { points: thinned(&points), style, faint: false });
        items.push(Item::Rod { ends: [Vector3::zeros(), end], style });
        items.push(Item::Ball { center: end, radius: 0.035, style });
    }
    (items, ["first axis", "second axis", "third axis"].map(String::from).to_vec(), poses.len() - 1)
}
