//! Decides by recent successes whether single states of a motion are tested before its pairs are searched.

/// Fractions of a motion at which states are tested: most motions that collide do so at their end or in the middle.
pub const PROBES: [f64; 2] = [1.0, 0.5];

/// Number of tests without contact that one contact pays for: about the cost of a search without test, in tests.
const TESTS_PER_CONTACT: u8 = 4;

/// Maximum number of tests without contact, until tests are given up.
const LARGEST_CREDIT: u8 = 16;

/// For each of [`PROBES`], the number of tests without contact that earlier contacts pay for. Among free motions there
/// are soon no tests, among colliding motions always. This changes no result, only the time until a contact is found.
#[derive(Clone, Debug, Default)]
pub struct ProbeCredits([u8; PROBES.len()]);

impl ProbeCredits {
    /// True if a test is worth its cost.
    pub fn is_worth(&self, probe: usize) -> bool {
        self.0[probe] > 0
    }

    /// Records the result of a test.
    pub fn tested(&mut self, probe: usize, is_contact: bool) {
        let credit = &mut self.0[probe];
        *credit = if is_contact {
            (*credit + TESTS_PER_CONTACT).min(LARGEST_CREDIT)
        } else {
            credit.saturating_sub(1)
        };
    }

    /// Records a contact that no test found: it pays for one test in the next motion.
    pub fn missed(&mut self) {
        for credit in &mut self.0 {
            *credit = (*credit).max(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_without_contact_are_paid_for_by_contacts() {
        for period in 1..40 {
            let mut credits = ProbeCredits::default();
            let (mut contacts, mut misses) = (0, 0);
            for motion in 0..1000 {
                let collides = motion % period == 0;
                let is_tested = credits.is_worth(0);
                if is_tested {
                    credits.tested(0, collides);
                } else if collides {
                    credits.missed();
                }
                contacts += usize::from(collides);
                misses += usize::from(is_tested && !collides);
                assert!(misses <= usize::from(TESTS_PER_CONTACT) * contacts);
            }
            assert!(misses > 0 || period == 1, "a motion in {period} collides");
        }
    }

    #[test]
    fn motions_that_always_collide_are_tested_from_the_second_on() {
        let mut credits = ProbeCredits::default();
        assert!(!credits.is_worth(0) && !credits.is_worth(1));
        credits.missed();
        for _ in 0..1000 {
            assert!(credits.is_worth(0));
            credits.tested(0, true);
        }
        assert!(credits.0[0] <= LARGEST_CREDIT);
    }
}
