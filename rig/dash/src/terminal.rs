//! The terminal: taken, and always given back.

use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::event::{
    DisableBracketedPaste, DisableMouseCapture, EnableBracketedPaste, EnableMouseCapture,
};
use ratatui::crossterm::terminal::{
    EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use ratatui::crossterm::{cursor, execute};
use ratatui::layout::Rect;
use std::io::{self, BufWriter, Stdout};

/// What a frame is gathered in before it is written.
const BUFFER: usize = 64 * 1024;

/// The terminal, as long as the dashboard has it.
#[derive(Debug)]
pub(crate) struct TerminalScreen {
    pub terminal: Terminal<CrosstermBackend<BufWriter<Stdout>>>,
    mouse: bool,
}

impl TerminalScreen {
    /// Takes it. A panic gives it back before it prints its words, so that they can be read.
    ///
    /// # Errors
    /// Standard output is no terminal, or one that is gone.
    pub fn take(mouse: bool) -> io::Result<TerminalScreen> {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            give_back();
            before(panic);
        }));
        let out = BufWriter::with_capacity(BUFFER, io::stdout());
        let terminal = Terminal::new(CrosstermBackend::new(out))?;
        let screen = TerminalScreen { terminal, mouse };
        screen.enter()?;
        Ok(screen)
    }

    fn enter(&self) -> io::Result<()> {
        enable_raw_mode()?;
        execute!(io::stdout(), EnterAlternateScreen, EnableBracketedPaste, cursor::Hide)?;
        if self.mouse {
            execute!(io::stdout(), EnableMouseCapture)?;
        }
        Ok(())
    }

    /// Gives it back while `other` has it, then takes it again and draws everything again.
    ///
    /// # Errors
    /// A terminal that is gone.
    pub fn lend(&mut self, other: impl FnOnce()) -> io::Result<()> {
        give_back();
        other();
        self.enter()?;
        self.redraw()
    }

    /// Lets the next frame be drawn as a whole.
    ///
    /// # Errors
    /// A terminal that is gone.
    pub fn redraw(&mut self) -> io::Result<()> {
        // `Terminal::clear` would ask the terminal where its cursor is, and the answer would go to whoever reads keys.
        let size = self.terminal.size()?;
        self.terminal.resize(Rect::new(0, 0, size.width, size.height))
    }
}

impl Drop for TerminalScreen {
    fn drop(&mut self) {
        give_back();
    }
}

/// Leaves it as it was found. Every step is tried, whatever became of the one before: the terminal may be gone.
fn give_back() {
    let _ = execute!(io::stdout(), DisableMouseCapture);
    let _ = execute!(io::stdout(), DisableBracketedPaste, LeaveAlternateScreen, cursor::Show);
    let _ = disable_raw_mode();
}
