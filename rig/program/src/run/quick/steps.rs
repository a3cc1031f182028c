//! The steps that are made when a program is loaded: their arms in the quick loop.

/// Matches a step; `rest` are the arms of the others. Besides the macros of [`operations`](super::super::operations),
/// the loop has those that are named here.
macro_rules! steps {
    ($step:ident, { $($rest:tt)* }) => {
        operations!($step.op, {
            op!(Set8) => put!(a!(), $step.c as u8),
            op!(Set16) => put!(a!(), $step.c as u16),
            op!(Set32) => put!(a!(), $step.c),
            op!(Grow16) => grow!(u16),
            op!(Grow32) => grow!(u32),
            op!(Sum16) => sum!(u16),
            op!(Sum32) => sum!(u32),
            op!(Equal8) => beside!(u8, |b, constant| b == constant),
            op!(Equal16) => beside!(u16, |b, constant| b == constant),
            op!(Equal32) => beside!(u32, |b, constant| b == constant),
            op!(Other8) => beside!(u8, |b, constant| b != constant),
            op!(Other16) => beside!(u16, |b, constant| b != constant),
            op!(Other32) => beside!(u32, |b, constant| b != constant),
            op!(Less16) => beside!(i16, |b, constant| b < constant),
            op!(Less32) => beside!(i32, |b, constant| b < constant),
            op!(LessEqual16) => beside!(i16, |b, constant| b <= constant),
            op!(LessEqual32) => beside!(i32, |b, constant| b <= constant),
            op!(Greater16) => beside!(i16, |b, constant| b > constant),
            op!(Greater32) => beside!(i32, |b, constant| b > constant),
            op!(GreaterEqual16) => beside!(i16, |b, constant| b >= constant),
            op!(GreaterEqual32) => beside!(i32, |b, constant| b >= constant),
            op!(Turn16) => turn!(i16, $step.c as i16),
            op!(Turn32) => turn!(i32, $step.c as i32),
            op!(Jump) => enter!($step.a),
            op!(Fetch8) => fetch!(u8),
            op!(Fetch16) => fetch!(u16),
            op!(Fetch32) => fetch!(u32),
            op!(Keep8) => keep!(u8),
            op!(Keep16) => keep!(u16),
            op!(Keep32) => keep!(u32),
            op!(Shift8) => shift_element!(u8),
            op!(Shift16) => shift_element!(u16),
            op!(Shift32) => shift_element!(u32),
            op!(AddElement32) => put!(a!(), load!(u32, b!()).wrapping_add(load!(u32, element!(u32)))),
            op!(AddElementF32) => put!(a!(), (load!(f32, b!()) + load!(f32, element!(f32))).canonical()),
            op!(EqualElement32) => by_element!(|b, element| b == element),
            op!(OtherElement32) => by_element!(|b, element| b != element),
            op!(LessElement32) => by_element!(|b, element| b < element),
            op!(LessEqualElement32) => by_element!(|b, element| b <= element),
            op!(GreaterElement32) => by_element!(|b, element| b > element),
            op!(GreaterEqualElement32) => by_element!(|b, element| b >= element),
            op!(ToOffset8) => to_offset!(u8),
            op!(ToOffset16) => to_offset!(u16),
            op!(ToOffset32) => to_offset!(u32),
            op!(Element) => put!(a!(), element!($step.d, $step.b) as u32),
            op!(Move8Set32) => move_and_set!(u8, u32),
            op!(GrowLess32) => grow_and!(|n, constant| n < constant),
            op!(GrowGreater32) => grow_and!(|n, constant| n > constant),
            op!(MulLess32) => mul_and!(|n, d| n < d),
            op!(MulGreater32) => mul_and!(|n, d| n > d),
            op!(ModEqual32) => mod_and!(|n, constant| n == constant),
            op!(ModOther32) => mod_and!(|n, constant| n != constant),
            op!(MulAdd32) => put!(a!(), load!(u32, b!()).wrapping_mul(load!(u32, c!())).wrapping_add(load!(u32, d!()))),
            op!(MulAddF32) => {
                let product = (load!(f32, b!()) * load!(f32, c!())).canonical();
                let d = load!(f32, d!());
                put!(a!(), (product + d).canonical());
            }
            op!(Address) => put!(a!(), b!() as u32),
            $($rest)*
        })
    };
}

pub(super) use steps;
