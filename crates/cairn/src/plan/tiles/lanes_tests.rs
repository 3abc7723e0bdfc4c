//! Every operation of every level, against one number at a time.

use super::lanes::{LANES, Lanes, TileCost};
use super::level::{Job, Simd, at_level};
use super::plain::Plain;

/// A small repeatable source of numbers.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        self.0 >> 33
    }
}

/// A number to compute with, one at a time.
trait Scalar: TileCost + std::fmt::Debug {
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    /// Numbers at the edges: nothing, the least steps, what is none, and twice that.
    fn edges() -> Vec<Self>;
    fn any(numbers: &mut Numbers) -> Self;
}

macro_rules! integer {
    ($type:ident) => {
        impl Scalar for $type {
            fn minus(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }
            fn times(self, other: Self) -> Self {
                self.wrapping_mul(other)
            }
            fn edges() -> Vec<Self> {
                let far = Self::FAR;
                vec![0, 1, 985, 1393, far / 2, far - 1, far, far + 1, far + 985, 2 * far - 1, 2 * far]
            }
            fn any(numbers: &mut Numbers) -> Self {
                (numbers.next() as $type).wrapping_mul(numbers.next() as $type) % (2 * Self::FAR + 1)
            }
        }
    };
}
integer!(u32);
integer!(u64);

macro_rules! float {
    ($type:ident) => {
        impl Scalar for $type {
            fn minus(self, other: Self) -> Self {
                self - other
            }
            fn times(self, other: Self) -> Self {
                self * other
            }
            fn edges() -> Vec<Self> {
                let tiny = $type::from_bits(1);
                let up = 1.0 + $type::EPSILON;
                vec![0.0, tiny, $type::MIN_POSITIVE, 0.1, 1.0, up, $type::MAX / 2.0, $type::MAX, Self::FAR]
            }
            fn any(numbers: &mut Numbers) -> Self {
                (numbers.next() as $type).sqrt() * 0.01
            }
        }
    };
}
float!(f32);
float!(f64);

type Sixteen<T> = [T; LANES];

fn sixteen<T: Scalar>(numbers: &mut Numbers) -> Sixteen<T> {
    let edges = T::edges();
    std::array::from_fn(|_| match numbers.next() % 2 {
        0 => T::any(numbers),
        _ => edges[numbers.next() as usize % edges.len()],
    })
}

/// What the operations make of some numbers.
#[derive(Debug)]
struct Results<T> {
    numbers: Vec<(&'static str, Sixteen<T>)>,
    masks: Vec<(&'static str, u16)>,
    codes: [i8; LANES],
    turned: Vec<T>,
}

/// What goes into them.
struct Operands<T> {
    a: Sixteen<T>,
    b: Sixteen<T>,
    mask: u16,
    masks: [u16; 8],
    block: Vec<T>,
}

const FROM_PITCH: usize = 19;
const TO_PITCH: usize = 17;

fn one_at_a_time<T: Scalar>(operands: &Operands<T>) -> Results<T> {
    let Operands { a, b, mask, masks, block } = operands;
    let each = |op: &dyn Fn(T, T) -> T| -> Sixteen<T> { std::array::from_fn(|i| op(a[i], b[i])) };
    let mask_of = |op: &dyn Fn(T, T) -> bool| (0..LANES).map(|i| u16::from(op(a[i], b[i])) << i).sum();
    let mut turned = vec![T::ZERO; LANES * TO_PITCH];
    for (row, col) in (0..LANES * LANES).map(|at| (at / LANES, at % LANES)) {
        turned[col * TO_PITCH + row] = block[row * FROM_PITCH + col];
    }
    Results {
        numbers: vec![
            ("splat", [a[0]; LANES]),
            ("plus", each(&|a, b| a.sum(b))),
            ("minus", each(&|a, b| a.minus(b))),
            ("times", each(&|a, b| a.times(b))),
            ("min", each(&|a, b| if b < a { b } else { a })),
            ("max", each(&|a, b| if b > a { b } else { a })),
            ("where_else", std::array::from_fn(|i| if mask >> i & 1 == 1 { a[i] } else { b[i] })),
            ("after", std::array::from_fn(|i| if i == 0 { b[LANES - 1] } else { a[i - 1] })),
            ("ahead", std::array::from_fn(|i| if i == LANES - 1 { b[0] } else { a[i + 1] })),
        ],
        masks: vec![("less", mask_of(&|a, b| a < b)), ("equal", mask_of(&|a, b| a == b))],
        codes: std::array::from_fn(|i| (0..8).find(|&k| masks[k as usize] >> i & 1 == 1).unwrap_or(-1)),
        turned,
    }
}

impl<T: Scalar> Job for &Operands<T> {
    type Number = T;
    type Result = Results<T>;

    #[inline(always)]
    unsafe fn run<L: Lanes<Number = T>>(self) -> Results<T> {
        let mut codes = [0; LANES];
        let mut turned = vec![T::ZERO; LANES * TO_PITCH];
        let mut numbers = vec![];
        // SAFETY: all arrays are as long as they have to be.
        unsafe {
            let (a, b) = (L::load(self.a.as_ptr()), L::load(self.b.as_ptr()));
            for (name, result) in [
                ("splat", L::splat(self.a[0])),
                ("plus", a.plus(b)),
                ("minus", a.minus(b)),
                ("times", a.times(b)),
                ("min", a.min(b)),
                ("max", a.max(b)),
                ("where_else", a.where_else(self.mask, b)),
                ("after", a.after(b)),
                ("ahead", a.ahead(b)),
            ] {
                let mut stored = [T::ZERO; LANES];
                result.store(stored.as_mut_ptr());
                numbers.push((name, stored));
            }
            L::store_codes(self.masks, codes.as_mut_ptr());
            L::transpose(self.block.as_ptr(), FROM_PITCH, turned.as_mut_ptr(), TO_PITCH);
            Results { numbers, masks: vec![("less", a.less(b)), ("equal", a.equal(b))], codes, turned }
        }
    }
}

/// Asserts that numbers are the same to the bit, which prints as the same; NaN is like NaN.
fn assert_same<T: Scalar>(is: &Results<T>, should_be: &Results<T>, operands: &Operands<T>, level: &str) {
    let (a, b) = (&operands.a, &operands.b);
    for ((name, is), (_, should_be)) in is.numbers.iter().zip(&should_be.numbers) {
        assert_eq!(format!("{is:?}"), format!("{should_be:?}"), "{level}: {name} of\n{a:?} and\n{b:?}");
    }
    assert_eq!(is.masks, should_be.masks, "{level}: {a:?} and\n{b:?}");
    assert_eq!(is.codes, should_be.codes, "{level}: {:?}", operands.masks);
    assert_eq!(is.turned, should_be.turned, "{level}: transpose");
}

fn check<T: Scalar>()
where
    Plain<T>: Lanes<Number = T>,
{
    let mut numbers = Numbers(7);
    for round in 0..300 {
        let mut masks = [0; 8].map(|_: u16| (numbers.next() & numbers.next()) as u16);
        if round % 3 == 0 {
            masks = masks.map(|mask| mask & numbers.next() as u16);
        }
        let operands = Operands {
            a: sixteen(&mut numbers),
            b: sixteen(&mut numbers),
            mask: numbers.next() as u16,
            masks,
            block: (0..LANES * FROM_PITCH).map(|_| T::any(&mut numbers)).collect(),
        };
        let should_be = one_at_a_time(&operands);
        for level in Simd::ALL.into_iter().filter(|level| level.is_available()) {
            assert_same(&at_level(level, &operands), &should_be, &operands, &level.to_string());
        }
        // SAFETY: plain Rust.
        let plain = unsafe { (&operands).run::<Plain<T>>() };
        assert_same(&plain, &should_be, &operands, "plain");
    }
}

#[test]
fn operations_on_u32_equal_those_on_one_number_at_every_level() {
    check::<u32>();
}

#[test]
fn operations_on_u64_equal_those_on_one_number_at_every_level() {
    check::<u64>();
}

#[test]
fn operations_on_f32_equal_those_on_one_number_at_every_level() {
    check::<f32>();
}

#[test]
fn operations_on_f64_equal_those_on_one_number_at_every_level() {
    check::<f64>();
}
