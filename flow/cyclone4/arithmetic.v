// Adders, subtractors, and the borrows that comparisons are, become carry chains.
//
// A cell in arithmetic mode holds two tables of three inputs, data a, data b and the carry in: one for the sum
// (upper half of the mask), one for the carry out (lower half). So a constant carry in and a complemented operand
// are part of the masks. A carry in that is a signal takes a cell that puts it on the chain, and a carry out that
// logic needs takes one that takes it off.

(* techmap_celltype = "$alu" *)
module cyclone4_alu (A, B, CI, BI, X, Y, CO);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  parameter _TECHMAP_CONSTMSK_CI_ = 0;
  parameter _TECHMAP_CONSTVAL_CI_ = 0;
  parameter _TECHMAP_CONSTMSK_BI_ = 0;
  parameter _TECHMAP_CONSTVAL_BI_ = 0;
  (* force_downto *) input [A_WIDTH-1:0] A;
  (* force_downto *) input [B_WIDTH-1:0] B;
  input CI, BI;
  (* force_downto *) output [Y_WIDTH-1:0] X, Y, CO;

  // Chains shorter than this save nothing: measured, on the whole detector.
  localparam SHORTEST = 5;

  localparam [0:0] COMPLEMENT = _TECHMAP_CONSTVAL_BI_ === 1'b1;

  // A carry in that is a signal takes a cell of its own; one that is constant is part of the first cell's masks.
  localparam SEED = _TECHMAP_CONSTMSK_CI_ !== 1'b1;
  localparam FIRST_CARRY = _TECHMAP_CONSTVAL_CI_ === 1'b1;

  // whether to complement is never a signal here: Yosys makes $alu of additions and subtractions only
  wire _TECHMAP_FAIL_ = Y_WIDTH < SHORTEST || _TECHMAP_CONSTMSK_BI_ !== 1'b1;

  (* force_downto *) wire [Y_WIDTH-1:0] a, b;
  \$pos #(.A_SIGNED(A_SIGNED), .A_WIDTH(A_WIDTH), .Y_WIDTH(Y_WIDTH)) extend_a (.A(A), .Y(a));
  \$pos #(.A_SIGNED(B_SIGNED), .A_WIDTH(B_WIDTH), .Y_WIDTH(Y_WIDTH)) extend_b (.A(B), .Y(b));
  assign X = a ^ b ^ {Y_WIDTH{COMPLEMENT}};

  localparam [7:0] SUM = COMPLEMENT ? 8'h69 : 8'h96;
  localparam [7:0] CARRY = COMPLEMENT ? 8'hB2 : 8'hE8;
  localparam [3:0] FIRST_SUM = FIRST_CARRY ? SUM[7:4] : SUM[3:0];
  localparam [3:0] FIRST_OUT = FIRST_CARRY ? CARRY[7:4] : CARRY[3:0];

  wire [Y_WIDTH:0] chain;
  genvar i;
  generate
    if (SEED)
      cycloneiv_lcell_comb #(.lut_mask(16'h00AA), .sum_lutc_input("datac")) seed (
        .dataa(CI), .datab(1'b1), .datac(1'b1), .datad(1'b1), .cin(1'b0), .cout(chain[0]));
    for (i = 0; i < Y_WIDTH; i = i + 1) begin: bits
      if (i == 0 && !SEED)
        cycloneiv_lcell_comb #(.lut_mask({{2{FIRST_SUM}}, {2{FIRST_OUT}}}), .sum_lutc_input("datac")) first (
          .dataa(a[i]), .datab(b[i]), .datac(1'b1), .datad(1'b1), .cin(1'b0),
          .combout(Y[i]), .cout(chain[i+1]));
      else
        cycloneiv_lcell_comb #(.lut_mask({SUM, CARRY}), .sum_lutc_input("cin")) full (
          .dataa(a[i]), .datab(b[i]), .datac(1'b1), .datad(1'b1), .cin(chain[i]),
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
