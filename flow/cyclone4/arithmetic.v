// Adders, subtractors and what compares with them become carry chains.
//
// A cell in arithmetic mode holds two tables of three inputs, data a, data b and the carry in: one for the sum
// (upper half of the mask), one for the carry out (lower half). So a constant carry in and a complemented operand
// are part of the masks. A carry in that is a signal takes a cell that puts it on the chain, and a carry out that
// logic needs takes one that takes it off. Low bits in which the carry stays constant need no chain.

(* techmap_celltype = "$alu" *)
module cyclone4_alu (A, B, CI, BI, X, Y, CO);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  parameter _TECHMAP_CONSTMSK_A_ = 0;
  parameter _TECHMAP_CONSTVAL_A_ = 0;
  parameter _TECHMAP_CONSTMSK_B_ = 0;
  parameter _TECHMAP_CONSTVAL_B_ = 0;
  parameter _TECHMAP_CONSTMSK_CI_ = 0;
  parameter _TECHMAP_CONSTVAL_CI_ = 0;
  parameter _TECHMAP_CONSTMSK_BI_ = 0;
  parameter _TECHMAP_CONSTVAL_BI_ = 0;
  (* force_downto *) input [A_WIDTH-1:0] A;
  (* force_downto *) input [B_WIDTH-1:0] B;
  input CI, BI;
  (* force_downto *) output [Y_WIDTH-1:0] X, Y, CO;

  // Chains shorter than this save nothing: measured, on the whole detector.
  localparam SHORTEST = 4;

  // A complement that is constant goes into the masks, one that is a signal into tables before the chain.
  localparam COMPLEMENT = _TECHMAP_CONSTMSK_BI_ === 1'b1 && _TECHMAP_CONSTVAL_BI_ === 1'b1;
  localparam VARIABLE = _TECHMAP_CONSTMSK_BI_ !== 1'b1;

  // Known place of an operand, extended: 0, 1, or 2 for a signal.
  function [1:0] known_a(input integer place);
    integer at;
    begin
      at = place < A_WIDTH ? place : A_WIDTH - 1;
      known_a = place >= A_WIDTH && !A_SIGNED ? 2'd0 :
                _TECHMAP_CONSTMSK_A_[at] === 1'b1 ? {1'b0, _TECHMAP_CONSTVAL_A_[at] === 1'b1} : 2'd2;
    end
  endfunction
  function [1:0] known_b(input integer place);
    integer at;
    reg value;
    begin
      at = place < B_WIDTH ? place : B_WIDTH - 1;
      value = place >= B_WIDTH && !B_SIGNED ? 1'b0 : _TECHMAP_CONSTVAL_B_[at] === 1'b1;
      known_b = VARIABLE || (_TECHMAP_CONSTMSK_B_[at] !== 1'b1 && !(place >= B_WIDTH && !B_SIGNED)) ? 2'd2 :
                {1'b0, value ^ COMPLEMENT};
    end
  endfunction

  // How many low bits have a constant carry out, whatever the signals are.
  function integer count_plain(input integer unused);
    integer place;
    reg [1:0] carry, a, b;
    reg on;
    begin
      carry = _TECHMAP_CONSTMSK_CI_ === 1'b1 ? {1'b0, _TECHMAP_CONSTVAL_CI_ === 1'b1} : 2'd2;
      on = 1;
      count_plain = 0;
      for (place = 0; place < Y_WIDTH; place = place + 1)
        if (on) begin
          a = known_a(place);
          b = known_b(place);
          on = 0;
          if (a != 2 && b != 2 && (a == b || carry != 2)) begin
            carry = a == b ? a : carry;
            on = 1;
          end else if (carry != 2 && (a == carry || b == carry))
            on = 1;
          if (on) count_plain = place + 1;
        end
    end
  endfunction
  function carry_after(input integer bits);
    integer place;
    reg [1:0] carry, a, b;
    begin
      carry = _TECHMAP_CONSTMSK_CI_ === 1'b1 ? {1'b0, _TECHMAP_CONSTVAL_CI_ === 1'b1} : 2'd2;
      for (place = 0; place < bits; place = place + 1) begin
        a = known_a(place);
        b = known_b(place);
        if (a != 2 && a == b) carry = a;
      end
      carry_after = carry[0];
    end
  endfunction

  localparam PLAIN = count_plain(0);
  localparam SEED = PLAIN == 0 && _TECHMAP_CONSTMSK_CI_ !== 1'b1;
  localparam FIRST_CARRY = carry_after(PLAIN);

  wire _TECHMAP_FAIL_ = Y_WIDTH - PLAIN < SHORTEST;

  (* force_downto *) wire [Y_WIDTH-1:0] a, b, true_b;
  \$pos #(.A_SIGNED(A_SIGNED), .A_WIDTH(A_WIDTH), .Y_WIDTH(Y_WIDTH)) extend_a (.A(A), .Y(a));
  \$pos #(.A_SIGNED(B_SIGNED), .A_WIDTH(B_WIDTH), .Y_WIDTH(Y_WIDTH)) extend_b (.A(B), .Y(b));
  wire [Y_WIDTH-1:0] data_b = VARIABLE ? b ^ {Y_WIDTH{BI}} : b;
  assign true_b = COMPLEMENT ? ~b : data_b;
  assign X = a ^ true_b;

  localparam [7:0] SUM = COMPLEMENT ? 8'h69 : 8'h96;
  localparam [7:0] CARRY = COMPLEMENT ? 8'hB2 : 8'hE8;
  localparam [3:0] FIRST_SUM = FIRST_CARRY ? SUM[7:4] : SUM[3:0];
  localparam [3:0] FIRST_OUT = FIRST_CARRY ? CARRY[7:4] : CARRY[3:0];

  wire [Y_WIDTH:PLAIN] chain;
  genvar i;
  generate
    for (i = 0; i < PLAIN; i = i + 1) begin: plain
      assign Y[i] = X[i] ^ carry_after(i);
      assign CO[i] = carry_after(i + 1);
    end
    if (SEED)
      cycloneiv_lcell_comb #(.lut_mask(16'h00AA), .sum_lutc_input("datac")) seed (
        .dataa(CI), .datab(1'b1), .datac(1'b1), .datad(1'b1), .cout(chain[0]));
    for (i = PLAIN; i < Y_WIDTH; i = i + 1) begin: bits
      if (i == PLAIN && !SEED)
        cycloneiv_lcell_comb #(.lut_mask({{2{FIRST_SUM}}, {2{FIRST_OUT}}}), .sum_lutc_input("datac")) first (
          .dataa(a[i]), .datab(data_b[i]), .datac(1'b1), .datad(1'b1), .combout(Y[i]), .cout(chain[i+1]));
      else
        cycloneiv_lcell_comb #(.lut_mask({SUM, CARRY}), .sum_lutc_input("cin")) full (
          .dataa(a[i]), .datab(data_b[i]), .datac(1'b1), .datad(1'b1), .cin(chain[i]),
          .combout(Y[i]), .cout(chain[i+1]));
      // what goes into the next sum can be read off it; only the last carry leaves the chain by itself
      if (i < Y_WIDTH - 1)
        assign CO[i] = X[i+1] ^ Y[i+1];
      else
        cycloneiv_lcell_comb #(.lut_mask(16'hF0F0), .sum_lutc_input("cin")) tap (
          .dataa(1'b1), .datab(1'b1), .datac(1'b1), .datad(1'b1), .cin(chain[i+1]), .combout(CO[i]));
    end
  endgenerate
endmodule
