//! Memory for lists as long as a picture.

/// A list of fewer bytes than two huge pages has few page faults.
const LARGE: usize = 4 << 20;

/// Returns a list of zeros, in huge pages if it is large and the system has some: with fewer page faults a
/// picture takes 0.9 of the time.
pub(crate) fn zeroed<T: bytemuck::Zeroable>(len: usize) -> Vec<T> {
    let list: Vec<T> = bytemuck::zeroed_vec(len);
    if size_of_val(&*list) >= LARGE {
        ask_for_huge_pages(&list);
    }
    list
}

#[cfg(target_os = "linux")]
#[expect(unsafe_code, reason = "advice is given to the system by an address")]
fn ask_for_huge_pages<T>(list: &[T]) {
    use rustix::mm::{Advice, madvise};

    let page = rustix::param::page_size();
    let start = list.as_ptr().cast_mut().cast::<u8>();
    let skipped = start.align_offset(page);
    let whole = size_of_val(list).saturating_sub(skipped) / page * page;
    // SAFETY: the pages are the list's own, and the advice changes neither what they hold nor who may use
    // them. An error leaves them as they are.
    let _ = unsafe { madvise(start.wrapping_add(skipped).cast(), whole, Advice::LinuxHugepage) };
}

/// Does nothing: other systems choose the pages themselves.
#[cfg(not(target_os = "linux"))]
fn ask_for_huge_pages<T>(_: &[T]) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_any_size_are_zeros() {
        for len in [0, 1, LARGE - 1, LARGE, LARGE + 1, 3 * LARGE + 4097] {
            let list = zeroed::<[u8; 3]>(len);
            assert!(list.len() == len && list.iter().all(|value| *value == [0; 3]), "{len}");
        }
    }

    #[test]
    fn large_lists_are_in_huge_pages_where_the_system_has_some() {
        if !std::fs::exists("/sys/kernel/mm/transparent_hugepage").is_ok_and(|is_there| is_there) {
            return;
        }
        let list = zeroed::<u8>(4 * LARGE);
        let middle = list.as_ptr() as usize + 2 * LARGE;
        let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
        let mut lines = maps.lines().skip_while(|line| {
            let range = line.split(' ').next().and_then(|range| range.split_once('-'));
            let ends = range.and_then(|(start, end)| {
                Some((usize::from_str_radix(start, 16).ok()?, usize::from_str_radix(end, 16).ok()?))
            });
            !ends.is_some_and(|(start, end)| (start..end).contains(&middle))
        });
        let flags = lines.find(|line| line.starts_with("VmFlags:")).unwrap();
        assert!(flags.split_ascii_whitespace().any(|flag| flag == "hg"), "{flags}");
    }
}
