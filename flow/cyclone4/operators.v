// What alumacc would not do as well for this device.

// Comparisons. With a constant they are tables, each of which takes three more bits; with a signal all are "less
// than", which is the borrow of one subtraction: of the others alumacc would also compare for equality.

(* techmap_celltype = "$lt $gt $ge $le" *)
module cyclone4_comparison (A, B, Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  parameter _TECHMAP_CELLTYPE_ = "";
  parameter _TECHMAP_CONSTMSK_A_ = 0;
  parameter _TECHMAP_CONSTMSK_B_ = 0;
  (* force_downto *) input [A_WIDTH-1:0] A;
  (* force_downto *) input [B_WIDTH-1:0] B;
  output [Y_WIDTH-1:0] Y;

  // longer ones would be slow
  localparam LONGEST = 16;
  localparam WIDTH = A_WIDTH > B_WIDTH ? A_WIDTH : B_WIDTH;
  localparam CONSTANT = WIDTH <= LONGEST &&
    (_TECHMAP_CONSTMSK_A_ === {A_WIDTH{1'b1}} || _TECHMAP_CONSTMSK_B_ === {B_WIDTH{1'b1}});
  localparam SIGNED = A_SIGNED && B_SIGNED;
  localparam SWAPPED = _TECHMAP_CELLTYPE_ == "$gt" || _TECHMAP_CELLTYPE_ == "$le";
  localparam [0:0] INVERTED = _TECHMAP_CELLTYPE_ == "$ge" || _TECHMAP_CELLTYPE_ == "$le";

  wire less;
  genvar i;
  generate
    if (CONSTANT) begin
      wire [WIDTH-1:0] a, b, x, y;
      \$pos #(.A_SIGNED(SIGNED), .A_WIDTH(A_WIDTH), .Y_WIDTH(WIDTH)) extend_a (.A(A), .Y(a));
      \$pos #(.A_SIGNED(SIGNED), .A_WIDTH(B_WIDTH), .Y_WIDTH(WIDTH)) extend_b (.A(B), .Y(b));
      assign x = SWAPPED ? b : a;
      assign y = SWAPPED ? a : b;
      wire [WIDTH:0] below;
      assign below[0] = 1'b0;
      for (i = 0; i < WIDTH; i = i + 1) begin: bits
        // a sign weighs the other way
        if (SIGNED && i == WIDTH - 1)
          assign below[i+1] = x[i] == y[i] ? below[i] : x[i];
        else
          assign below[i+1] = x[i] == y[i] ? below[i] : y[i];
      end
      assign less = below[WIDTH];
    end else if (_TECHMAP_CELLTYPE_ == "$lt")
      wire _TECHMAP_FAIL_ = 1;
    else if (SWAPPED)
      \$lt #(.A_SIGNED(B_SIGNED), .B_SIGNED(A_SIGNED), .A_WIDTH(B_WIDTH), .B_WIDTH(A_WIDTH), .Y_WIDTH(1))
        swapped (.A(B), .B(A), .Y(less));
    else
      \$lt #(.A_SIGNED(A_SIGNED), .B_SIGNED(B_SIGNED), .A_WIDTH(A_WIDTH), .B_WIDTH(B_WIDTH), .Y_WIDTH(1))
        plain (.A(A), .B(B), .Y(less));
  endgenerate
  assign Y = less ^ INVERTED;
endmodule

// One carry chain for each addition: sums of three it would first reduce to two, by two tables for each bit.

(* techmap_celltype = "$add $sub" *)
module cyclone4_addition (A, B, Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  parameter _TECHMAP_CELLTYPE_ = "";
  input [A_WIDTH-1:0] A;
  input [B_WIDTH-1:0] B;
  output [Y_WIDTH-1:0] Y;

  localparam [0:0] SUBTRACT = _TECHMAP_CELLTYPE_ == "$sub";
  wire [Y_WIDTH-1:0] x, carries;
  // an operand is only extended by its sign where both are signed
  localparam SIGNED = A_SIGNED && B_SIGNED;
  \$alu #(.A_SIGNED(SIGNED), .B_SIGNED(SIGNED), .A_WIDTH(A_WIDTH), .B_WIDTH(B_WIDTH), .Y_WIDTH(Y_WIDTH))
    sum (.A(A), .B(B), .CI(SUBTRACT), .BI(SUBTRACT), .X(x), .Y(Y), .CO(carries));
endmodule
