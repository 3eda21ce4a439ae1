//! Compiles matrix functions: products, determinant, inverse. All are plain sums of products, so
//! that every step is rounded and traceable.

use std::rc::Rc;

use naga::{Scalar, TypeInner, VectorSize};

use super::super::code::{Class, Op, RealBinary, RealUnary, Reg};
use super::function::Function;

impl Function<'_, '_> {
    /// Emits one sum of products for each pair of lists.
    pub fn dots(&mut self, scalar: Scalar, pairs: &[(Vec<Reg>, Vec<Reg>)]) -> Rc<[Reg]> {
        if scalar.width == 4 && self.b.rounds {
            return pairs.iter().map(|(a, b)| self.dot_by_steps(scalar, a, b)).collect();
        }
        let class = if scalar.width == 8 { Class::Wide } else { Class::Real };
        let to = self.b.temporaries(class, pairs.len());
        let mut operands = Vec::new();
        for (to, (a, b)) in to.iter().zip(pairs) {
            operands.push(to.0);
            operands.extend(a.iter().chain(b).map(|reg| reg.0));
        }
        let n = pairs[0].0.len() as u8;
        self.b.push(if scalar.width == 8 { Op::DDot(n) } else { Op::Dot(n) }, &[], &operands);
        self.narrowed(scalar, to.into())
    }

    fn dot_by_steps(&mut self, scalar: Scalar, a: &[Reg], b: &[Reg]) -> Reg {
        let products = self.f2(RealBinary::Mul, scalar, a, b);
        let mut sum = products[0];
        for product in &products[1..] {
            sum = self.f2(RealBinary::Add, scalar, &[sum], &[*product])[0];
        }
        sum
    }

    /// Compiles a matrix product; `None` if the operands multiply component by component.
    pub fn matrix_product(
        &mut self,
        left: &TypeInner,
        right: &TypeInner,
        a: &[Reg],
        b: &[Reg],
    ) -> Option<Rc<[Reg]>> {
        // Columns are one after the other.
        let row = |m: &[Reg], columns: VectorSize, rows: VectorSize, row: usize| -> Vec<Reg> {
            (0..columns as usize).map(|column| m[column * rows as usize + row]).collect()
        };
        let column = |m: &[Reg], rows: VectorSize, column: usize| -> Vec<Reg> {
            m[column * rows as usize..(column + 1) * rows as usize].to_vec()
        };
        // Rows of the left operand times columns of the right; a vector is a row on the left and a
        // column on the right: GLSL 4.60 §5.10.
        match (left, right) {
            (
                TypeInner::Matrix { columns, rows, scalar },
                TypeInner::Matrix { columns: right_columns, rows: right_rows, .. },
            ) => {
                let mut pairs = Vec::new();
                for c in 0..*right_columns as usize {
                    for r in 0..*rows as usize {
                        pairs.push((row(a, *columns, *rows, r), column(b, *right_rows, c)));
                    }
                }
                Some(self.dots(*scalar, &pairs))
            }
            (TypeInner::Matrix { columns, rows, scalar }, TypeInner::Vector { .. }) => {
                let pairs: Vec<_> =
                    (0..*rows as usize).map(|r| (row(a, *columns, *rows, r), b.to_vec())).collect();
                Some(self.dots(*scalar, &pairs))
            }
            (TypeInner::Vector { .. }, TypeInner::Matrix { columns, rows, scalar }) => {
                let pairs: Vec<_> =
                    (0..*columns as usize).map(|c| (a.to_vec(), column(b, *rows, c))).collect();
                Some(self.dots(*scalar, &pairs))
            }
            _ => None,
        }
    }

    /// Emits `a * d - b * c`.
    fn minor(&mut self, scalar: Scalar, a: Reg, d: Reg, b: Reg, c: Reg) -> Reg {
        let products = self.f2(RealBinary::Mul, scalar, &[a, b], &[d, c]);
        self.f2(RealBinary::Sub, scalar, &products[..1], &products[1..])[0]
    }

    /// Emits the sum of products with alternating signs of a cofactor expansion.
    fn expand(&mut self, scalar: Scalar, factors: &[Reg], minors: &[Reg]) -> Reg {
        let products = self.f2(RealBinary::Mul, scalar, factors, minors);
        let mut sum = products[0];
        for (i, product) in products.iter().enumerate().skip(1) {
            let op = if i % 2 == 1 { RealBinary::Sub } else { RealBinary::Add };
            sum = self.f2(op, scalar, &[sum], &[*product])[0];
        }
        sum
    }

    /// Emits the determinant of the submatrix of these columns and of as many of the last rows,
    /// expanded by its first row.
    fn determinant_of(&mut self, scalar: Scalar, m: &[Reg], columns: &[usize], n: usize) -> Reg {
        let size = columns.len();
        let first = n - size;
        let at = |column: usize, row: usize| m[column * n + row];
        match size {
            1 => at(columns[0], first),
            2 => self.minor(
                scalar,
                at(columns[0], first),
                at(columns[1], first + 1),
                at(columns[1], first),
                at(columns[0], first + 1),
            ),
            _ => {
                let factors: Vec<Reg> = columns.iter().map(|&c| at(c, first)).collect();
                let minors: Vec<Reg> = (0..size)
                    .map(|skip| {
                        let rest: Vec<usize> =
                            columns.iter().copied().filter(|&c| c != columns[skip]).collect();
                        self.determinant_of(scalar, m, &rest, n)
                    })
                    .collect();
                self.expand(scalar, &factors, &minors)
            }
        }
    }

    pub fn determinant(&mut self, scalar: Scalar, m: &[Reg], n: usize) -> Reg {
        let columns: Vec<usize> = (0..n).collect();
        self.determinant_of(scalar, m, &columns, n)
    }

    /// Emits the adjugate divided by the determinant.
    pub fn inverse(&mut self, scalar: Scalar, m: &[Reg], n: usize) -> Rc<[Reg]> {
        let determinant = self.determinant(scalar, m, n);
        let mut cofactors = Vec::with_capacity(n * n);
        for column in 0..n {
            for row in 0..n {
                // The adjugate is the transpose of the cofactors.
                let rest: Vec<Reg> = (0..n)
                    .filter(|&c| c != row)
                    .flat_map(|c| (0..n).filter(|&r| r != column).map(move |r| (c, r)))
                    .map(|(c, r)| m[c * n + r])
                    .collect();
                let minor = self.determinant(scalar, &rest, n - 1);
                cofactors.push(if (column + row) % 2 == 1 {
                    self.f1(RealUnary::Neg, scalar, &[minor])[0]
                } else {
                    minor
                });
            }
        }
        self.f2(RealBinary::Div, scalar, &cofactors, &[determinant])
    }
}
