//! The comparison of configured and fitted modules when the bus starts (io: section 12).

use profile::{MODULE_INDICES, ModuleState, Tm3BusState};

/// A position of the bus as the application configures it, in the order of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConfiguredPosition {
    /// Its index in TM3_MODULE_R, below [`MODULE_INDICES`] (io:BUS-05).
    pub index: usize,
    /// The internal ID code, by which alone modules are known (io:OPT-04).
    pub id: u8,
    /// The parameter *Optional module* (io:OPT-01).
    pub optional: bool,
}

/// What fitted modules are that no configured one is left for (io:OPT-07).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExtraModules {
    /// A difference: the bus does not start.
    #[default]
    Refused,
    /// Nothing.
    Ignored,
}

/// What the comparison found at an index of TM3_MODULE_R.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionState {
    /// The state of the module.
    pub state: ModuleState,
    /// The internal ID code of what is fitted there.
    pub fitted: Option<u8>,
    /// Its place among the fitted modules, whether it answers or not.
    pub place: Option<usize>,
}

/// What the comparison found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusStart {
    /// By index of TM3_MODULE_R.
    pub modules: [PositionState; MODULE_INDICES],
    /// PLC_R.i_uiTM3BusState: in order, or a configuration error. A bus without power is not compared.
    pub state: Tm3BusState,
    /// How many fitted modules no configured one was left for.
    pub extra: usize,
}

impl BusStart {
    /// Whether the bus starts (io:OPT-02, io:OPT-03).
    pub fn starts(&self) -> bool {
        self.state == Tm3BusState::Ok
    }
}

/// Compares the configured modules with the internal ID codes of the fitted ones, position by position from the controller on;
/// one that is fitted and does not answer has none, and takes its position all the same.
///
/// A fitted module of the configured code matches, whatever its reference (io:OPT-04). Where another code answers, or none, an
/// optional module is missing and the fitted module is compared with the next configured one (io:OPT-03). A mandatory
/// module is then a configuration error if something is fitted there (io:OPT-06), and a bus error if nothing is (io:ERR-01);
/// the bus does not start (io:OPT-02), and the positions after it are compared all the same (rig definition).
pub fn compare_modules(
    configured: &[ConfiguredPosition],
    fitted: &[Option<u8>],
    extra: ExtraModules,
) -> BusStart {
    let mut modules =
        [PositionState { state: ModuleState::Empty, fitted: None, place: None }; MODULE_INDICES];
    let mut starts = true;
    let mut left = fitted;
    for position in configured {
        let next = fitted.len() - left.len();
        let found = match left.split_first() {
            Some((Some(id), _)) if position.optional && *id != position.id => None,
            Some((id, rest)) => {
                left = rest;
                *id
            }
            None => None,
        };
        let state = match found {
            Some(id) if id == position.id => ModuleState::Ok,
            Some(_) => ModuleState::ConfigurationError,
            None if position.optional => ModuleState::MissingOptional,
            None => ModuleState::BusError,
        };
        starts &= matches!(state, ModuleState::Ok | ModuleState::MissingOptional);
        if let Some(module) = modules.get_mut(position.index) {
            let place = (fitted.len() - left.len() > next).then_some(next);
            *module = PositionState { state, fitted: found, place };
        }
    }
    starts &= left.is_empty() || extra == ExtraModules::Ignored;
    let state = if starts { Tm3BusState::Ok } else { Tm3BusState::ConfigurationError };
    BusStart { modules, state, extra: left.len() }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Positions from index 0 on, by ID code; a code below 0 is of an optional module.
    pub(in crate::bus) fn positions(codes: &[i16]) -> Vec<ConfiguredPosition> {
        let one = |(index, code): (usize, &i16)| ConfiguredPosition {
            index,
            id: u8::try_from(code.unsigned_abs()).unwrap(),
            optional: *code < 0,
        };
        codes.iter().enumerate().map(one).collect()
    }

    fn answering(ids: &[u8]) -> Vec<Option<u8>> {
        ids.iter().copied().map(Some).collect()
    }

    /// The numbers of the states from index 0 on as far as modules are configured, and that of the bus.
    fn compared(configured: &[i16], fitted: &[u8]) -> (Vec<u16>, u16) {
        let found = compare_modules(&positions(configured), &answering(fitted), ExtraModules::Refused);
        let states = found.modules.iter().map(|one| one.state.code());
        assert!(states.clone().skip(configured.len()).all(|code| code == 0));
        (states.take(configured.len()).collect(), found.state.code())
    }

    // io:OPT-02, io:OPT-03, io:OPT-04, io:OPT-06, io:ERR-01, io:DIAG-03: the numbers are those of the system variables.
    #[test]
    fn each_row_of_the_rules() {
        assert_eq!(compared(&[132, 129], &[132, 129]), (vec![3, 3], 3));
        assert_eq!(compared(&[], &[]), (vec![], 3));
        // A mandatory module is missing at the end, another one answers, nothing answers at all.
        assert_eq!(compared(&[132, 129], &[132]), (vec![3, 2], 1));
        assert_eq!(compared(&[132, 129], &[132, 133]), (vec![3, 1], 1));
        assert_eq!(compared(&[132, 129], &[]), (vec![2, 2], 1));
        // Missing in the middle: what comes after it answers in its place.
        assert_eq!(compared(&[132, 129, 193], &[132, 193]), (vec![3, 1, 2], 1));
        // One that is there and silent keeps its position.
        let silent =
            compare_modules(&positions(&[132, -129, 193]), &[None, None, Some(193)], ExtraModules::Refused);
        assert_eq!([0, 1, 2].map(|index| silent.modules[index].state.code()), [2, 5, 3]);
        // Optional ones.
        assert_eq!(compared(&[132, -129, 193], &[132, 193]), (vec![3, 5, 3], 3));
        assert_eq!(compared(&[132, -129, 193], &[132, 129, 193]), (vec![3, 3, 3], 3));
        assert_eq!(compared(&[-132, -129], &[]), (vec![5, 5], 3));
        assert_eq!(compared(&[-132, -129], &[129]), (vec![5, 3], 3));
        assert_eq!(compared(&[-132, 129], &[133]), (vec![5, 1], 1));
        // One fitted module is taken for the first that it can be: the mandatory one is then missing.
        assert_eq!(compared(&[-132, 132], &[132]), (vec![3, 2], 1));
        // The last ones are not configured.
        assert_eq!(compared(&[132], &[132, 129]), (vec![3], 1));
        assert_eq!(compared(&[-132], &[129]), (vec![5], 1));
    }

    // io:OPT-07
    #[test]
    fn extra_modules_can_be_ignored() {
        let found = compare_modules(&positions(&[132]), &answering(&[132, 129, 129]), ExtraModules::Ignored);
        assert!(found.starts());
        assert_eq!(found.extra, 2);
        assert!(
            !compare_modules(&positions(&[132]), &answering(&[132, 129]), ExtraModules::Refused).starts()
        );
    }

    // io:BUS-05: local modules from 0 on, remote ones from 7 on, one bus.
    #[test]
    fn states_stand_at_the_index_of_their_module() {
        let mut configured = positions(&[132, 129]);
        configured[1].index = 7;
        let found = compare_modules(&configured, &answering(&[132, 133]), ExtraModules::Refused);
        let ok = PositionState { state: ModuleState::Ok, fitted: Some(132), place: Some(0) };
        let wrong =
            PositionState { state: ModuleState::ConfigurationError, fitted: Some(133), place: Some(1) };
        assert_eq!((found.modules[0], found.modules[7]), (ok, wrong));
        assert_eq!(found.modules.iter().filter(|one| one.state == ModuleState::Empty).count(), 12);
        // An index that TM3_MODULE_R has not shows nowhere.
        configured[1].index = MODULE_INDICES;
        assert!(!compare_modules(&configured, &answering(&[132, 133]), ExtraModules::Refused).starts());
    }

    /// The fitted module that a position is compared with: the one after those that the positions before it have used.
    fn compared_with(place: usize, missing: &[bool], fitted: &[u8]) -> Option<u8> {
        fitted.get(missing[..place].iter().filter(|missing| !**missing).count()).copied()
    }

    /// The rules as a condition instead of a walk: of all ways to declare optional modules missing, the one in which exactly
    /// those are missing that are compared with another code or with nothing.
    fn oracle(configured: &[ConfiguredPosition], fitted: &[u8]) -> (Vec<u16>, u16) {
        let consistent = |missing: &Vec<bool>| {
            configured.iter().enumerate().all(|(place, one)| {
                missing[place] == (one.optional && compared_with(place, missing, fitted) != Some(one.id))
            })
        };
        let ways = 0..1_u32 << configured.len();
        let ways =
            ways.map(|way| (0..configured.len()).map(|place| way >> place & 1 == 1).collect::<Vec<_>>());
        let right: Vec<_> = ways.filter(consistent).collect();
        assert_eq!(right.len(), 1, "{configured:?} {fitted:?}");
        let missing = &right[0];
        let states: Vec<u16> = configured
            .iter()
            .enumerate()
            .map(|(place, one)| match compared_with(place, missing, fitted) {
                _ if missing[place] => 5,
                None => 2,
                Some(id) if id == one.id => 3,
                Some(_) => 1,
            })
            .collect();
        let used = missing.iter().filter(|missing| !**missing).count();
        let starts = states.iter().all(|state| [3, 5].contains(state)) && used == fitted.len();
        (states, if starts { 3 } else { 1 })
    }

    /// Whether what is fitted is what is configured without some optional modules.
    fn can_match(configured: &[ConfiguredPosition], fitted: &[u8]) -> bool {
        let Some((first, rest)) = configured.split_first() else { return fitted.is_empty() };
        let there = fitted.first() == Some(&first.id) && can_match(rest, &fitted[1..]);
        there || first.optional && can_match(rest, fitted)
    }

    proptest! {
        #[test]
        fn the_walk_finds_what_the_rules_say(
            codes in prop::collection::vec(prop::sample::select(vec![-4_i16, -3, -2, -1, 1, 2, 3, 4]), 0..9),
            fitted in prop::collection::vec(1_u8..5, 0..9),
        ) {
            let configured = positions(&codes);
            let found = compared(&codes, &fitted);
            prop_assert_eq!(&found, &oracle(&configured, &fitted));
            prop_assert!(found.1 == 1 || can_match(&configured, &fitted));
        }

        // Where no two modules have one code, the bus starts if there is any way in which the lists go together.
        #[test]
        fn different_codes_are_never_mistaken(
            codes in prop::sample::subsequence((1_i16..10).collect::<Vec<_>>(), 0..9).prop_shuffle(),
            optional in prop::collection::vec(any::<bool>(), 9),
            there in prop::collection::vec(prop::bool::weighted(0.8), 9),
        ) {
            let signed = |(code, optional): (&i16, &bool)| if *optional { -*code } else { *code };
            let codes: Vec<i16> = codes.iter().zip(&optional).map(signed).collect();
            let configured = positions(&codes);
            let fitted = configured.iter().zip(&there).filter(|(_, there)| **there);
            let fitted: Vec<u8> = fitted.map(|(one, _)| one.id).collect();
            prop_assert_eq!(compared(&codes, &fitted).1 == 3, can_match(&configured, &fitted));
        }
    }
}
